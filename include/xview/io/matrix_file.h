// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>

namespace xview {

/// A transform as four lines of four numbers, row by row, last line 0 0 0 1: what CloudCompare
/// (Edit > Apply transformation, -APPLY_TRANS) reads and PDAL (filters.transformation, option
/// matrix) takes as text. Reading the numbers back gives the same bits. Appears whole or not at
/// all.
void writeMatrix(const std::string& path, const Eigen::Isometry3d& T_target_source,
                 double scale = 1);

}  // namespace xview
