// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/options.h"

namespace xview {

/// For each point the number of its cluster (0 …, ordered by the first point of each), or -1 if the
/// cluster is smaller than min_points or the point is not finite. Exactly the components of
/// pcl::EuclideanClusterExtraction, which joins points whose squared distance in single precision
/// is less than tolerance_m^2. In linear expected time: all points in a cell of side tolerance_m /
/// sqrt(3) belong together, and only cells that are near and not yet connected are compared point
/// by point. Throws Error if points spread over more than a million cells on an axis even after
/// empty space is left out.
std::vector<int> euclideanClusters(const std::vector<Eigen::Vector3f>& points, float tolerance_m,
                                   int min_points);

/// Per-class Euclidean clusters of a labelled cloud; classes whose role is `ignored` are left out.
/// With instances (non-zero) each (class, instance) is clustered for itself; points of instance 0
/// are clustered as a class. Roads and walls of a whole town hang together: a blob of a surface
/// class that spreads further than max_surface_m in x or y is cut at whole multiples of it in the
/// frame of the cloud, and pieces with fewer than min_points are dropped. `blob_of_point`, if
/// given, receives the blob of each point or -1. Blobs are ordered by label, then by first point.
std::vector<Blob> extractBlobs(const LabelledCloud& cloud, const LabelSet& set,
                               const BlobOptions& options,
                               std::vector<int>* blob_of_point = nullptr);

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

ImageBlobs extractImageBlobs(const Frame& frame, const LabelSet& set, double max_range_m,
                             const BlobOptions& options = {});

}  // namespace xview
