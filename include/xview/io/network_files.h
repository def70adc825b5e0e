// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/types/color_image.h"
#include "xview/types/network_input.h"

namespace xview::io {

/// YAML of how a network wants its images: {labels, ids, width, height, mean, std, order: rgb|bgr};
/// only `labels` must be there. Throws Error with path:line.
NetworkInput readNetworkInput(const std::string& path);

/// PNG or JPEG of 8 bits; grey images become colours. Throws Error.
ColorImage readColors(const std::string& path);

}  // namespace xview::io
