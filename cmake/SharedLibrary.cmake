# SPDX-License-Identifier: BSD-3-Clause
# libxview.so: what programs of others need, in one library that shows its interface only. The program and the tests link
# the layers themselves.
set(shared_layers base process place search pose match verdict map localizer compare io)
set(archives "")
foreach(layer ${shared_layers})
  list(APPEND archives $<TARGET_FILE:xview_${layer}>)
endforeach()
list(JOIN archives "," archives)

file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/shared_library.cpp CONTENT "// All of the library is in its layers.\n")
add_library(xview SHARED ${PROJECT_BINARY_DIR}/shared_library.cpp)
list(TRANSFORM shared_layers PREPEND xview_)
target_link_libraries(xview
  PUBLIC Eigen3::Eigen pcl_common
  PRIVATE "-Wl,--whole-archive,${archives},--no-whole-archive" ${shared_layers})
target_include_directories(xview INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
target_compile_features(xview PUBLIC cxx_std_17)
set(symbols ${PROJECT_SOURCE_DIR}/cmake/exported_symbols.map)
target_link_options(xview PRIVATE -Wl,--version-script=${symbols} -Wl,--no-undefined)
# Before 1.0 another minor version may break programs, as SemVer has it.
set_target_properties(xview PROPERTIES LINK_DEPENDS ${symbols} VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
