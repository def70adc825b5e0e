// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "xview/types/localization.h"

namespace xview {

/// What a piece of the query says about the best hypothesis.
enum class Testimony {
  kept,           ///< speaks for it
  contradicting,  ///< speaks against it
  unknown         ///< the map was never seen there
};

const char* toString(Testimony testimony);

/// A sample of the query's view from above, or a vertex of its graph.
struct Contribution {
  enum class Kind { sample, vertex };
  Kind kind = Kind::sample;
  std::string name;  ///< channel of a sample, class of a vertex
  Testimony testimony = Testimony::unknown;
  Eigen::Vector3d map_position = Eigen::Vector3d::Zero();  ///< where the pose puts it [m]
  std::optional<double> nats;                              ///< its share of the score; samples only
  std::optional<double> expected;  ///< what it would give at a true pose on average; samples only
  std::optional<Eigen::Vector3d> partner;      ///< nearest of its kind in the map [m]
  std::optional<std::uint32_t> partner_index;  ///< map vertex, if the partner is one
  std::optional<double> residual_m;            ///< horizontal for samples, in space for vertices
};

/// Why a query got its verdict: all samples first, then all vertices.
struct Explanation {
  std::vector<Contribution> contributions;
};

}  // namespace xview
