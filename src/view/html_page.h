// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace xview {

/// The page around the data: everything before the JSON text of the scene, and everything behind
/// it.
extern const char* const kHtmlPageBegin;
extern const char* const kHtmlPageEnd;

}  // namespace xview
