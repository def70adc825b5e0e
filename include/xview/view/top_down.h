// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/view/scene.h"

namespace xview {

struct TopDownOptions {
  int width = 1600;   ///< pixels, 320 to 16000
  int height = 1200;  ///< pixels, 240 to 16000
  bool zoom = true;   ///< a query that is small in its map gets a panel of its own
};

/// A picture from above as the bytes of a PNG: the map by class, its key frames, each query at its
/// estimated pose with its matches and view directions, the true pose if known, scale bar and
/// legend. Needs no display. Throws UsageError on an impossible size.
std::vector<std::uint8_t> drawTopDown(const Scene& scene, const TopDownOptions& options = {});

}  // namespace xview
