// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/frame.h"
#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"

namespace xview::graph {

struct BlobOptions {
  double tolerance_m = 0.5;  ///< two points of a class nearer than this are in one blob
  int min_points = 20;       ///< smaller blobs are dropped
  double voxel_m = 0.1;      ///< thin a frame to one point per voxel and class first; 0 = off
  double max_surface_m =
      20;  ///< surfaces that spread further are cut into squares; 0 = off (paper)
  /// Regions of label images of a smaller share of the image are leaves and specks, whose median
  /// depth says little (the paper's scripts: 0.002).
  double min_share = 0.001;
  std::string instances = "all";  ///< classes whose instances part a region of a label image
};

template <class Visitor>
void visit(BlobOptions& o, Visitor&& field) {
  field("tolerance_m", o.tolerance_m, Range{0.01, 100},
        "points of one class nearer than this are one blob [m]");
  field("min_points", o.min_points, Range{1, 1e9}, "drop blobs with fewer points");
  field("voxel_m", o.voxel_m, Range{0, 10},
        "thin points to one per voxel and class before clustering; 0 = off [m]");
  field("max_surface_m", o.max_surface_m, Range{0, 1e6},
        "cut blobs of surface classes that spread further into squares of this side; 0 = off [m]");
  field("min_share", o.min_share, Range{0, 1},
        "drop regions of label images of a smaller share of the image");
  field("instances", o.instances, Choices{{"all", "dynamic", "none"}},
        "classes whose instances part a region of a label image");
}

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

}  // namespace xview::graph
