// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/image.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"

namespace xview::graph {

struct CleanOptions {
  bool enabled = true;
  /// Half size of the element that may also take pixels of other classes (paper: 4 px).
  int boundary_px = 0;
};

template <class Visitor>
void visit(CleanOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "smooth label images before they are lifted");
  field("boundary_px", o.boundary_px, Range{0, 50},
        "close classes over their neighbours, too, by this much; 0 = keep boundaries [px]");
}

/// Drops specks (connected regions of less than 12 px, 3 px of poles) from a label image and closes
/// the classes around them (dilation, then erosion, per class; paper section III-A). Sizes are
/// pixels of the image as it is. Specks that no class closes over become unlabelled: id 0, or the
/// highest unused id if 0 is a class of the set that is not ignored.
///
/// Deviations from the paper. Classes are closed from large to small area, first ignored ones, then
/// surfaces, then objects, and later ones win: a pole 3 px wide survives. And a closing takes only
/// the pixels of specks, unless boundary_px allows more: closing everything by 4 px fills the gaps
/// between things with points at the wrong depth. On rendered towns (320x240) it keeps 98.3-99.0 %
/// of right labels where the filling of specks keeps 99.8 %, and leaves CNN-like labels 0.1 to 1.1
/// points worse; 1 px is a draw (99.7 %, +0.02 points).
LabelImage cleanLabels(const LabelImage& labels, const LabelSet& set, const CleanOptions& options);

}  // namespace xview::graph
