# SPDX-License-Identifier: BSD-3-Clause
message(STATUS "xview ${PROJECT_VERSION}: ${CMAKE_BUILD_TYPE}, tests ${XVIEW_BUILD_TESTS}, "
               "tools ${XVIEW_BUILD_TOOLS}, bench ${XVIEW_BUILD_BENCH}, "
               "simulator (Embree) ${XVIEW_WITH_SIM}, Python ${XVIEW_PYTHON}, MPI ${XVIEW_MPI}")
