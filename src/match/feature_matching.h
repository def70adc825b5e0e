// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

#include "xview/base/labelled_cloud.h"

namespace xview::match {

/// A pose of six degrees of freedom at which surfaces of a query lie on surfaces of a map.
struct FeaturePose {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  /// Of the surfaces that face along a direction, the share that lies on surfaces of the map, in
  /// the direction where it is least: the smallest generalized eigenvalue of the scatters of
  /// normals of what lies on the map and of all. In rooms of right angles wrong poses lay floors on
  /// floors and one wall on a wall; few lay something on something in all three directions.
  double share = 0;
};

/// Voxels of a cloud that hold points.
std::size_t voxelCount(const LabelledCloud& cloud, double voxel);

/// A cloud as local features see it: thinned to voxels, each with a normal towards whoever saw it
/// and a Fast Point Feature Histogram (Rusu et al., ICRA 2009). Neither classes nor the direction
/// of gravity are asked for.
class FeatureCloud {
 public:
  /// `view_points`: from where it was seen; nobody knows if there is none. Side of a voxel in the
  /// unit of the cloud.
  FeatureCloud(const LabelledCloud& cloud, const std::vector<Eigen::Vector3d>& view_points,
               double voxel, int threads);
  FeatureCloud(FeatureCloud&&) noexcept;
  ~FeatureCloud();

  double voxel() const { return voxel_; }
  /// Of the cloud with -y in place of y.
  FeatureCloud mirrored() const;

 private:
  friend std::vector<FeaturePose> matchFeatures(const FeatureCloud& query, const FeatureCloud& map,
                                                std::size_t most);
  struct Content;
  FeatureCloud(double voxel, std::unique_ptr<const Content> content);
  double voxel_;
  std::unique_ptr<const Content> content_;
};

/// Poses at which the two clouds may be one: features that are nearest to one another in both
/// directions vote for them (consistentPoses), and point-to-plane ICP refines each. Those with the
/// largest share first; `most` at most, each another one than those before it. Deterministic.
std::vector<FeaturePose> matchFeatures(const FeatureCloud& query, const FeatureCloud& map,
                                       std::size_t most);

}  // namespace xview::match
