// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "xview/types/image.h"

namespace xview {

/// Red, green and blue of each pixel.
using ColorImage = Image<std::array<std::uint8_t, 3>>;

}  // namespace xview
