// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/labels.h"
#include "xview/options.h"

namespace xview {

/// Drops specks (connected regions of less than 12 px, 3 px of poles) from a label image and closes
/// the classes around them (dilation, then erosion, per class; paper section III-A). Sizes are
/// pixels of the image as it is. Specks that no class closes over become unlabelled: id 0, or the
/// highest unused id if 0 is a class of the set that is not ignored.
///
/// Deviations from the paper. Classes are closed from large to small area, first ignored ones, then
/// surfaces, then objects, and later ones win: a pole 3 px wide survives. And a closing takes only
/// the pixels of specks, unless boundary_px allows more: closing everything by 4 px fills the gaps
/// between objects with points at the wrong depth. On rendered towns (320x240) it keeps 98.3-99.0 %
/// of right labels where the filling of specks keeps 99.8 %, and leaves CNN-like labels 0.1 to 1.1
/// points worse; 1 px is a draw (99.7 %, +0.02 points).
LabelImage cleanLabels(const LabelImage& labels, const LabelSet& set, const CleanOptions& options);

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

}  // namespace xview
