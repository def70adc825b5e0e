// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/types/image.h"

namespace xview::graph {

/// Pixels [begin, end) of one row with the same label (and instance).
struct LabelRun {
  int row = 0;
  int begin = 0, end = 0;
  std::uint32_t region = 0;
};

/// An 8-connected region of one label (and instance).
struct LabelRegion {
  std::uint16_t label = 0;
  std::uint16_t instance = 0;
  int pixels = 0;
  int min_x = 0, min_y = 0, max_x = 0, max_y = 0;  ///< bounding box, inclusive
};

/// All regions of a label image in order of their first pixel, and the runs they consist of, row by
/// row.
struct LabelRegions {
  std::vector<LabelRun> runs;
  std::vector<LabelRegion> regions;
};

/// One pass over the image for all labels together (OpenCV would need one per class). `instances`
/// may be empty; else it must be as large as `labels`.
LabelRegions findLabelRegions(const LabelImage& labels, const LabelImage& instances = {});

}  // namespace xview::graph
