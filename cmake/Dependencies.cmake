# SPDX-License-Identifier: BSD-3-Clause
# Everything comes from the distribution's packages (see ./run).

# PCL's own find script would drag VTK, Qt and OpenNI into every target; none of them is used.
foreach(package VTK OpenNI OpenNI2 libusb)
  set(CMAKE_DISABLE_FIND_PACKAGE_${package} ON)
endforeach()
find_package(PCL 1.12 QUIET REQUIRED COMPONENTS common kdtree octree search sample_consensus
             filters segmentation registration)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs)
find_package(Ceres REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(SQLiteCpp REQUIRED)
find_package(ZLIB REQUIRED)
# libdeflate brings no CMake package before 1.15; it is linked by its name.
find_path(XVIEW_LIBDEFLATE_INCLUDE libdeflate.h)
find_library(XVIEW_LIBDEFLATE deflate)
mark_as_advanced(XVIEW_LIBDEFLATE_INCLUDE XVIEW_LIBDEFLATE)
if(NOT XVIEW_LIBDEFLATE_INCLUDE OR NOT XVIEW_LIBDEFLATE)
  message(FATAL_ERROR "libdeflate is missing: apt-get install libdeflate-dev")
endif()
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
if(XVIEW_BUILD_TOOLS)
  find_package(CLI11 REQUIRED)
endif()
if(XVIEW_BUILD_TESTS)
  find_package(GTest REQUIRED)
endif()
if(XVIEW_BUILD_BENCH)
  find_package(benchmark REQUIRED)
endif()

find_package(embree 3 QUIET)
set(XVIEW_WITH_SIM ${embree_FOUND})
