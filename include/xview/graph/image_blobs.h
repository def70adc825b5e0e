// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "xview/types/blob.h"
#include "xview/types/frame.h"
#include "xview/types/option_field.h"

namespace xview {

/// Sizes are those at 640x480: min_pixels is scaled with the image area, the distance with its
/// width.
struct ImageBlobOptions {
  int min_pixels = 300;          ///< smaller regions are dropped
  double edge_distance_px = 10;  ///< blobs whose contours come this near are neighbours
};

template <class Visitor>
void visit(ImageBlobOptions& o, Visitor&& field) {
  field("min_pixels", o.min_pixels, Range{1, 1e9},
        "drop image regions smaller than this (at 640x480, scaled) [px]");
  field("edge_distance_px", o.edge_distance_px, Range{0, 1e4},
        "connect regions whose contours come this near (at 640x480, scaled) [px]");
}

/// Blobs and edges in image space, as the paper has them: 8-connected regions of the label image
/// per class and instance, edges where contours come near. Positions are 3-D all the same: the
/// median depth of the region at its pixel centroid, in the odometry frame. Covariance and bounds
/// are those of its points. Regions without any depth up to max_range_m are dropped. Throws Error
/// if images differ in size.
struct ImageBlobs {
  std::vector<Blob> blobs;
  BlobEdges edges;
  Image<std::int32_t> blob_of_pixel;  ///< index into blobs, or -1
};

ImageBlobs extractImageBlobs(const Frame& frame, const LabelSet& set,
                             const ImageBlobOptions& options, double max_range_m);

}  // namespace xview
