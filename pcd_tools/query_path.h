// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "answer.h"
#include "queries.h"
#include "xview/options.h"

namespace xview::tools {

/// Where an accepted answer puts the odometry frame of its query.
struct Anchor {
  std::size_t index = 0;  ///< of the pose that was answered: the last one of the window
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< T_map_query takes points of the query times this
  Matrix6d covariance = Matrix6d::Zero();
  double confidence = 0;

  Eigen::Isometry3d inMap(Eigen::Isometry3d T_odom_sensor) const;
};

/// The way of one query in the map, from its accepted answers.
class QueryPath {
 public:
  explicit QueryPath(const QueryInput& input);
  void add(
      const Answer& answer);  ///< in the order of the recording; those not accepted are passed over

  bool empty() const { return anchors_.empty(); }
  /// All poses of the query in the map frame. At the frame that was answered odometry and map
  /// agree; between two of them the disagreement is spread along the way, before the first and
  /// after the last one it stays.
  std::vector<Eigen::Isometry3d> poses() const;
  /// The accepted answer that is surest; the first of equals.
  const Anchor& surest() const;

  void writeTrajectory(const std::string& path) const;  ///< TUM lines of poses()
  /// Vertex 0 is the map (fixed), 1 to n are poses(); edges of the odometry, and from the map to
  /// each answered pose.
  void writeGraph(const std::string& path, const PosteriorOptions& odometry) const;
  void writeTransform(const std::string& path) const;  ///< T_map_query of surest()

 private:
  std::vector<Eigen::Isometry3d> T_odom_sensor_;
  std::vector<double> stamps_s_;
  std::vector<Anchor> anchors_;
};

}  // namespace xview::tools
