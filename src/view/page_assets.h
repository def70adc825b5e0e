// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

// The files of the page, which are part of the program.

std::string pageTemplate();   ///< page/page.html
std::string pageStyle();      ///< page/page.css
std::string pageScript();     ///< page/page.js
std::string pageLibraries();  ///< three.js with its camera controls and its lines

}  // namespace xview
