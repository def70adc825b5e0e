# SPDX-License-Identifier: BSD-3-Clause
# One language level, one baseline instruction set, one set of warnings for every target.

# PCL's binaries are built for baseline x86-64. Any -m flag that changes the alignment of Eigen types
# makes its objects incompatible (crashes in the sample-consensus rejector and in NDT).
if("${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}" MATCHES "-march=|-mavx|-mfma|-ffast-math")
  message(FATAL_ERROR
    "CMAKE_CXX_FLAGS contains -march/-mavx/-mfma/-ffast-math. PCL is compiled for baseline x86-64 and "
    "crashes when it meets objects with another Eigen alignment. Remove the flag: the hot loops "
    "choose AVX2/AVX-512 at run time by themselves.")
endif()

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
add_link_options(-Wl,--as-needed)
set(CMAKE_BUILD_RPATH ${PROJECT_BINARY_DIR})  # where modules are found before they are installed

# Sources of a target are compiled eight at a time: templates are instantiated once for all of them.
option(XVIEW_UNITY_BUILD "Compile sources in groups: sooner done as a whole, later after a change of one file" OFF)
function(xview_group_sources target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${XVIEW_UNITY_BUILD} UNITY_BUILD_BATCH_SIZE 8)
  if(XVIEW_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)  # takes a grouped source for a header
  endif()
endfunction()

add_library(xview_warnings INTERFACE)
target_compile_options(xview_warnings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor
  $<$<BOOL:${XVIEW_WERROR}>:-Werror>)

# xview_layer(<name> SOURCES … [PUBLIC …] [PRIVATE …] [APART]): one static library per layer. APART: not compiled in groups,
# which takes longer where functions get inlined into one another, as those of Ceres do.
function(xview_layer name)
  cmake_parse_arguments(arg "APART" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(xview_${name} STATIC ${arg_SOURCES})
  add_library(xview::${name} ALIAS xview_${name})
  set_target_properties(xview_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(xview_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
    $<INSTALL_INTERFACE:include>)
  target_compile_features(xview_${name} PUBLIC cxx_std_17)
  target_link_libraries(xview_${name} PUBLIC ${arg_PUBLIC}
                        PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:xview_warnings>)
  set_property(GLOBAL APPEND PROPERTY XVIEW_LAYERS xview_${name})
  xview_precompile(xview_${name} src/precompiled.h)
  if(NOT arg_APART)
    xview_group_sources(xview_${name})
  endif()
endfunction()

# xview_module(<name> FOR <layer> SOURCES … LINK …): a library that a layer opens when it needs it (src/process/module.h).
function(xview_module name)
  cmake_parse_arguments(arg "" "FOR" "SOURCES;LINK" ${ARGN})
  add_library(xview_${name} MODULE ${arg_SOURCES})
  set_target_properties(xview_${name} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  target_include_directories(xview_${name} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(xview_${name} PRIVATE ${arg_LINK} xview_warnings)
  add_dependencies(${arg_FOR} xview_${name})
  install(TARGETS xview_${name} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/xview)
endfunction()

# xview_test(<name> SOURCES … LINK … [TIMEOUT seconds] [COST seconds] [APART]): one binary and one ctest entry; registration
# fails if a *_test.cpp of the folder is in no target. COST: about how long it takes; ctest begins with the longest. APART: its
# files have different worlds under the same names, and are not compiled in groups.
function(xview_test name)
  cmake_parse_arguments(arg "APART" "TIMEOUT;COST" "SOURCES;LINK" ${ARGN})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  if("${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELWITHDEBINFO}" MATCHES "-fsanitize=")
    math(EXPR arg_TIMEOUT "10 * ${arg_TIMEOUT}")
  endif()
  add_executable(${name}_test ${arg_SOURCES})
  target_include_directories(${name}_test PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_link_libraries(${name}_test PRIVATE ${arg_LINK} xview_warnings xview_test_main)
  xview_precompile(${name}_test test/precompiled.h)
  if(NOT arg_APART)
    xview_group_sources(${name}_test)
  endif()
  add_test(NAME ${name} COMMAND ${name}_test)
  set_tests_properties(${name} PROPERTIES TIMEOUT ${arg_TIMEOUT})
  if(arg_COST)
    set_tests_properties(${name} PROPERTIES COST ${arg_COST})
  endif()
  file(GLOB present RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *_test.cpp)
  get_property(known DIRECTORY PROPERTY XVIEW_TEST_SOURCES)
  list(APPEND known ${arg_SOURCES})
  set_property(DIRECTORY PROPERTY XVIEW_TEST_SOURCES "${known}")
  cmake_language(EVAL CODE "
    cmake_language(DEFER CALL xview_check_tests [[${CMAKE_CURRENT_SOURCE_DIR}]])")
endfunction()

function(xview_check_tests directory)
  file(GLOB present RELATIVE ${directory} ${directory}/*_test.cpp)
  get_property(known DIRECTORY ${directory} PROPERTY XVIEW_TEST_SOURCES)
  foreach(file ${present})
    if(NOT file IN_LIST known)
      message(FATAL_ERROR "${directory}/${file} belongs to no test target")
    endif()
  endforeach()
endfunction()
