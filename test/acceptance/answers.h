// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "support/json_lines.h"

namespace xview::test {

/// Runs the program and expects exit code 0.
std::string outputOf(const std::vector<std::string>& arguments);

/// Runs `localize --json --quiet` with these arguments and returns its answers; 0 and 3 (ran well,
/// something was refused) are the exit codes it may have.
std::string localize(const std::vector<std::string>& arguments);

/// Positions of a file of TUM or KITTI poses, one per line.
std::vector<Eigen::Vector3d> positionsIn(const std::string& path);

/// Position of the sensor in the map at the last frame of a query; NaN if there is no pose.
Eigen::Vector3d positionIn(const Json& answer);

/// Answers held against the truth.
struct Tally {
  std::size_t windows = 0;   ///< queries that were answered
  std::size_t right = 0;     ///< of windows: within the tolerance, accepted or not
  std::size_t accepted = 0;  ///< of windows
  std::size_t wrong = 0;     ///< accepted farther from the truth than the tolerance, or nowhere
  double worst_m = 0;        ///< largest error of an accepted one
  std::string reasons;       ///< of every answer, for the message of a test that fails
};

/// Counts one answer that is so far from the truth; NaN where there is no truth.
void count(Tally& tally, const Json& answer, double error_m, double tolerance_m);

/// `truth` has one position per frame number of the recording, or that of its only frame.
Tally tallyOf(const std::string& answers, const std::vector<Eigen::Vector3d>& truth,
              double tolerance_m);

/// Queries for which no answer is right.
Tally tallyOfNegatives(const std::string& answers);

/// Elements of a PLY file.
struct MeshSize {
  std::size_t vertices = 0, faces = 0;
};

/// Reads an ASCII PLY of coloured triangles to its last word; fails the test where the body is not
/// what the header says.
MeshSize sizeOfMesh(const std::string& path);

}  // namespace xview::test
