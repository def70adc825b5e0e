// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

#include "input_file.h"

namespace xview {

// Poses as they stand in one line of a text file. `file` gives path and line of what is wrong.

/// Every word as a finite number.
std::vector<double> numbersOf(const std::vector<std::string_view>& words, const InputFile& file);

/// tx ty tz qx qy qz qw; the quaternion may be off by rounding (1 %) and is normalised.
Eigen::Isometry3d poseFromTum(const double* numbers, const InputFile& file);

/// The first three rows of a 4x4 matrix, row by row; its rotation may be off by 1e-3 and is made
/// orthonormal.
Eigen::Isometry3d poseFromRows(const double* numbers, const InputFile& file);

}  // namespace xview
