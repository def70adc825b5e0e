# SPDX-License-Identifier: BSD-3-Clause
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

configure_file(cmake/version.h.in ${PROJECT_BINARY_DIR}/include/xview/version.h @ONLY)
if(BUILD_SHARED_LIBS)
  include(cmake/SharedLibrary.cmake)
  install(TARGETS xview EXPORT xviewTargets)
else()
  add_library(xview INTERFACE)
  target_link_libraries(xview INTERFACE xview_compare xview_io)
  get_property(layers GLOBAL PROPERTY XVIEW_LAYERS)
  install(TARGETS xview ${layers} EXPORT xviewTargets)
endif()
add_library(xview::xview ALIAS xview)
target_include_directories(xview INTERFACE $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>)

install(EXPORT xviewTargets NAMESPACE xview:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/xview)
install(DIRECTORY include/xview DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${PROJECT_BINARY_DIR}/include/xview/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/xview)
install(DIRECTORY config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/xview)
configure_package_config_file(cmake/xviewConfig.cmake.in xviewConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/xview)
write_basic_package_version_file(xviewConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/xviewConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/xviewConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/xview)

# pkg-config, for those who build without CMake: the shared library, or the layers with all that they need.
find_path(pcl_include pcl/point_types.h HINTS ${PCL_INCLUDE_DIRS} NO_CACHE REQUIRED)
set(pc_libs -lxview)
if(NOT BUILD_SHARED_LIBS)
  list(TRANSFORM layers PREPEND -l OUTPUT_VARIABLE pc_layers)
  list(REMOVE_ITEM pc_layers -lxview_sim -lxview_view -lxview_eval)
  set(pc_libs -Wl,--start-group ${pc_layers} -Wl,--end-group
    -lSQLiteCpp -lsqlite3 -ldeflate -lexpat -lzstd -llz4 -lbz2 -lopencv_imgproc -lopencv_core
    -lceres -lglog -lgflags -lspqr -lcholmod -lamd -lcamd -lccolamd -lcolamd -lsuitesparseconfig -lcxsparse -llapack -lblas
    -lpcl_registration -lpcl_filters -lpcl_sample_consensus -lpcl_segmentation -lpcl_search -lpcl_kdtree -lpcl_octree
    -lyaml-cpp -lfmt -ltbb)
endif()
list(APPEND pc_libs -lpcl_common)
list(JOIN pc_libs " " pc_libs)
# Where the prefix is from the file itself, wherever all of it was moved to.
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/xview.pc.in xview.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/xview.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
