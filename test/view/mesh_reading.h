// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/view/color_mesh.h"

namespace xview::test {

/// Readers that are written after the formats' descriptions, not after the writers; they throw
/// std::runtime_error.
ColorMesh readVtk(const std::string& text);
ColorMesh readPly(const std::string& text);

}  // namespace xview::test
