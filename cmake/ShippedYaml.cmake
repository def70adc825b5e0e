# SPDX-License-Identifier: BSD-3-Clause
# xview_shipped_yaml(<header> <Name> <folder> <file>...): YAML files below a folder as strings of a header, kName[] of
# struct Name {name, yaml}, so that the program needs no files at run time. The name is the path without its ending.
function(xview_shipped_yaml header type folder)
  set(files ${ARGN})
  list(SORT files)
  set(entries "")
  foreach(file ${files})
    file(RELATIVE_PATH name ${folder} ${file})
    string(REGEX REPLACE "\\.yaml$" "" name ${name})
    file(READ ${file} yaml)
    string(APPEND entries "    {\"${name}\", R\"yaml(${yaml})yaml\"},\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  file(CONFIGURE OUTPUT ${header} @ONLY CONTENT
"// SPDX-License-Identifier: BSD-3-Clause
// Made of YAML files by CMake.
#pragma once

namespace xview {

struct @type@ {
  const char* name;
  const char* yaml;
};

inline constexpr @type@ k@type@[] = {
@entries@};

}  // namespace xview
")
endfunction()
