// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace xview::io {

struct StampedPose {
  double stamp_s = 0;
  Eigen::Isometry3d T_frame_sensor = Eigen::Isometry3d::Identity();
};

/// TUM lines "stamp tx ty tz qx qy qz qw" or KITTI lines of 12 numbers (stamp = line number);
/// comments start with #. Throws Error with path:line, what was expected and found (wrong count,
/// not a number, not a rotation: poses that are not rigid within 1e-3 are refused).
std::vector<StampedPose> readPoses(const std::string& path);

/// One pose per frame. As many lines as frames: in order. More lines: line `number` (from 0)
/// belongs to frame `number`. Fewer: Error.
std::vector<StampedPose> posesOfFrames(const std::string& path,
                                       const std::vector<std::int64_t>& frame_numbers);

/// TUM lines, 9 decimals; written beside and renamed.
void writeTumPoses(const std::string& path, const std::vector<StampedPose>& poses);

/// A transform as four lines of four numbers, row by row, last line 0 0 0 1: what CloudCompare
/// (Edit > Apply transformation, -APPLY_TRANS) reads and PDAL (filters.transformation, option
/// matrix) takes as text. Reading the numbers back gives the same bits. Appears whole or not at
/// all.
void writeMatrix(const std::string& path, const Eigen::Isometry3d& T_target_source,
                 double scale = 1);

/// Reads such a file: a rotation, one scale for all axes, and a translation. Throws Error.
Eigen::Affine3d readMatrix(const std::string& path);

/// Poses with what is known between them, as solvers of pose graphs take it.
struct PoseGraph {
  /// The pose of `to` seen from `from`. `covariance` is that of Localization: x y z [m], rx ry rz
  /// [rad] of `to`, in the axes of `from`, left increment (t_true = t + d, R_true = exp(w^) R).
  struct Edge {
    std::size_t from = 0, to = 0;  ///< indices into poses
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  };
  std::vector<Eigen::Isometry3d> poses;
  std::vector<std::size_t> fixed;  ///< poses that a solver must not move
  std::vector<Edge> edges;
};

/// VERTEX_SE3:QUAT, FIX and EDGE_SE3:QUAT lines of g2o; ids are the indices. The information of an
/// edge is what g2o expects: the upper triangle, row by row, for the translation in the axes of
/// `to` and the vector part of the unit quaternion, which is half the angle. Covariances that
/// cannot be inverted are widened until they can (1 mm, 1e-4 rad). Appears whole or not at all.
/// Throws std::out_of_range if an index is no pose.
void writePoseGraph(const std::string& path, const PoseGraph& graph);

}  // namespace xview::io
