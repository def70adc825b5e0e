// SPDX-License-Identifier: BSD-3-Clause
#include "drawing.h"

// The assembler puts a file into the program; the paths come from CMake.
#define XVIEW_EMBED(symbol, path)                                                           \
  __asm__(".section .rodata\n" #symbol "_begin:\n.incbin \"" path "\"\n" #symbol            \
          "_end:\n.byte 0\n.global " #symbol "_begin\n.global " #symbol "_end\n.previous"); \
  extern "C" const char symbol##_begin[], symbol##_end[];

XVIEW_EMBED(xview_page_html, XVIEW_PAGE_DIR "/page.html")
XVIEW_EMBED(xview_page_css, XVIEW_PAGE_DIR "/page.css")
XVIEW_EMBED(xview_page_js, XVIEW_PAGE_DIR "/page.js")
XVIEW_EMBED(xview_three, XVIEW_THREE_DIR "/three.min.js")
XVIEW_EMBED(xview_controls, XVIEW_THREE_DIR "/examples/js/controls/OrbitControls.js")
XVIEW_EMBED(xview_lines_geometry, XVIEW_THREE_DIR "/examples/js/lines/LineSegmentsGeometry.js")
XVIEW_EMBED(xview_lines_material, XVIEW_THREE_DIR "/examples/js/lines/LineMaterial.js")
XVIEW_EMBED(xview_lines, XVIEW_THREE_DIR "/examples/js/lines/LineSegments2.js")

namespace xview {

std::map<std::string, std::string> pageParts() {
  std::string libraries;
  for (const auto& [begin, end] : {std::pair(xview_three_begin, xview_three_end),
                                   {xview_controls_begin, xview_controls_end},
                                   {xview_lines_geometry_begin, xview_lines_geometry_end},
                                   {xview_lines_material_begin, xview_lines_material_end},
                                   {xview_lines_begin, xview_lines_end}})
    libraries += std::string(begin, end) + "\n";
  return {{"page", {xview_page_html_begin, xview_page_html_end}},
          {"style", {xview_page_css_begin, xview_page_css_end}},
          {"script", {xview_page_js_begin, xview_page_js_end}},
          {"libraries", libraries}};
}

}  // namespace xview
