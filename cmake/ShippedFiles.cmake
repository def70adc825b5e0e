# SPDX-License-Identifier: BSD-3-Clause
# Files of config/ become part of the program, so that it needs none at run time.
# xview_shipped_yaml(<header> <Name> <folder> <file>...): YAML files below a folder as strings of a header, kName[] of
# struct Name {name, yaml}. The name is the path without its ending.
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

# xview_shipped_texts(<source> <namespace> (<kName> <file>)...): text files of config/ as strings of a source.
function(xview_shipped_texts source namespace)
  set(definitions "")
  set(pairs ${ARGN})
  while(pairs)
    list(POP_FRONT pairs name file)
    set(path ${PROJECT_SOURCE_DIR}/config/${file})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
    file(READ ${path} text)
    string(APPEND definitions "
extern const char* const ${name};
const char* const ${name} = R\"text(${text})text\";
")
  endwhile()
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT
"// SPDX-License-Identifier: BSD-3-Clause
// Made of text files by CMake.

namespace @namespace@ {
@definitions@
}  // namespace @namespace@
")
endfunction()
