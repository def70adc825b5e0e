// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "xview/types/blob.h"
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
}

/// Angles between neighbouring measurements of a spinning scanner.
struct BeamSpacing {
  double azimuth_rad = 0;    ///< of one beam, from measurement to measurement
  double elevation_rad = 0;  ///< between two beams
  bool isKnown() const { return azimuth_rad > 0 && elevation_rad > 0; }
};

/// The spacing of the beams that measured these points around the origin of their frame, or nothing
/// if they are no scan: in narrow sectors of a scan the elevations come in steps, those of a cloud
/// from many places do not. The order of the points does not matter. Rings (the beam of each point)
/// are used if there are any and if they lie at elevations of their own, but they are not needed.
BeamSpacing measureBeamSpacing(const LabelledCloud& cloud,
                               const std::vector<std::uint16_t>& rings = {});

/// How a cloud was scanned.
struct ScanView {
  Eigen::Isometry3d T_cloud_sensor =
      Eigen::Isometry3d::Identity();  ///< sensor in the cloud's frame
  BeamSpacing beams;
};

/// Joins clusters (numbers from 0, or -1) whose points lie next to one another in the range image:
/// at most two beams apart, one of them lost, upwards and sideways, and at most `depth_m` in range.
/// `points` are in the frame of the sensor; only those further away than `depth_m` over the spacing
/// are looked at, because a tolerance of `depth_m` has joined the others already.
void joinAlongBeams(const std::vector<Eigen::Vector3f>& points, const BeamSpacing& beams,
                    float depth_m, std::vector<int>& cluster_of_point);

/// How many points of a thin post a scan holds at that range, at most `most` and at least a few.
int pointsOfThinThing(double range_m, const BeamSpacing& beams, int most);

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
///
/// The beams of a scan are further apart than tolerance_m far away, and fewer of them meet a thing.
/// If the cloud is one scan and its spacing is known, neighbours in its range image are joined as
/// well (joinAlongBeams), and a blob of a thin class (pole-like, trunk, other object) needs no more
/// points than a post would have where it stands (pointsOfThinThing), unless it is a fragment
/// beside a larger blob; both change nothing near the sensor.
std::vector<Blob> extractBlobs(const LabelledCloud& cloud, const LabelSet& set,
                               const BlobOptions& options,
                               std::vector<int>* blob_of_point = nullptr,
                               const ScanView& scan = {});

}  // namespace xview::graph
