// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/types/image.h"

namespace xview {

/// A portable float map of one channel ("Pf"). Rows are stored from the bottom up; a negative scale
/// means little endian, and its size is not applied (writers do not agree what it means). Values as
/// stored. Throws Error.
Image<float> readPfm(const std::string& path);

}  // namespace xview
