// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/image.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"

namespace xview {

struct CleanOptions {
  bool enabled = true;
  int closing_px = 4;      ///< half size of the dilate/erode element (paper: 4 px)
  int min_speck_px = 12;   ///< connected regions smaller than this become unlabelled

};

template <class Visitor>
void visit(CleanOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "smooth label images before they are lifted");
  field("closing_px", o.closing_px, Range{0, 50}, "dilate/erode by this much; thin objects are kept [px]");
  field("min_speck_px", o.min_speck_px, Range{0, 1e6}, "drop connected label regions smaller than this [px]");
}

/// Smooths the boundaries of a label image by a closing (dilation, then erosion) per class, paper section III-A, and
/// drops specks (they become `unlabelled`, id 0). Deviation from the paper: classes are closed from large to small area and
/// object classes win over surfaces, so that a pole 3 px wide survives.
LabelImage cleanLabels(const LabelImage& labels, const LabelSet& set, const CleanOptions& options);

}  // namespace xview
