# SPDX-License-Identifier: BSD-3-Clause
# Parsing the headers of PCL, Eigen and the standard library is more than half of the work of a build;
# src/precompiled.h names those that are parsed once for all targets instead, test/precompiled.h those of tests.

# ccache keeps no objects of files with a precompiled header (unless its `sloppiness` allows it), so a
# build with a compiler launcher goes without. Such builds also show the headers that a file forgot.
if(CMAKE_CXX_COMPILER_LAUNCHER)
  set(without_launcher OFF)
else()
  set(without_launcher ON)
endif()
option(XVIEW_PRECOMPILED_HEADERS "Parse headers of other libraries once per build" ${without_launcher})

# xview_precompile(<target> <header>): the first target of a header precompiles it, the others use that.
function(xview_precompile target header)
  if(NOT XVIEW_PRECOMPILED_HEADERS)
    return()
  endif()
  get_property(owner GLOBAL PROPERTY XVIEW_OWNER_OF_${header})
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  else()
    target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/${header})
    set_property(GLOBAL PROPERTY XVIEW_OWNER_OF_${header} ${target})
  endif()
  # Executables would be compiled with -fPIE, but all users of one header need the same flags.
  target_compile_options(${target} PRIVATE -fPIC)
  cmake_language(EVAL CODE "cmake_language(DEFER CALL xview_skip_precompiled ${target})")
endfunction()

# Files with compiler flags of their own cannot use it; they are known at the end of their folder.
function(xview_skip_precompiled target)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_source_file_property(flags ${source} COMPILE_OPTIONS)
    if(flags)
      set_source_files_properties(${source} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endforeach()
endfunction()
