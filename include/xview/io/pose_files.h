// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
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

/// The pose at a time, between the two poses around it, of poses in order of their stamps; none if
/// these are farther apart than `longest_gap_s`.
std::optional<Eigen::Isometry3d> poseAt(const std::vector<StampedPose>& poses, double stamp_s,
                                        double longest_gap_s);

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

}  // namespace xview::io
