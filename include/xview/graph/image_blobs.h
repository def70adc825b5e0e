// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "xview/types/blob.h"
#include "xview/types/frame.h"

namespace xview::graph {

/// Blobs and edges in image space, as the paper has them: 8-connected regions of the label image
/// per class and instance, edges where contours come near; smaller regions than 300 px of 640x480
/// are dropped. Positions are 3-D all the same: the
/// median depth of the region at its pixel centroid, in the odometry frame. Covariance and bounds
/// are those of its points. Regions without any depth up to max_range_m are dropped. Throws Error
/// if images differ in size.
struct ImageBlobs {
  std::vector<Blob> blobs;
  BlobEdges edges;
  Image<std::int32_t> blob_of_pixel;  ///< index into blobs, or -1
};

ImageBlobs extractImageBlobs(const Frame& frame, const LabelSet& set, double max_range_m);

}  // namespace xview::graph
