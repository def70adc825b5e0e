# SPDX-License-Identifier: BSD-3-Clause
# xview_shipped_labels(<header>): config/labels/*.yaml as strings of a header, so that the program needs no files at run time.
function(xview_shipped_labels header)
  file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/config/labels/*.yaml)
  list(SORT files)
  set(entries "")
  foreach(file ${files})
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} yaml)
    string(APPEND entries "    {\"${name}\", R\"yaml(${yaml})yaml\"},\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  file(CONFIGURE OUTPUT ${header} @ONLY CONTENT
"// SPDX-License-Identifier: BSD-3-Clause
// Made of config/labels/*.yaml by CMake.
#pragma once

namespace xview {

struct ShippedLabels {
  const char* name;
  const char* yaml;
};

inline constexpr ShippedLabels kShippedLabels[] = {
@entries@};

}  // namespace xview
")
endfunction()
