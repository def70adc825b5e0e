// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace xview {

/// A gravity-aligned pose: p_map = Rz(yaw) * p_query + (x, y), and what speaks for it.
struct PlacePose {
  double x = 0, y = 0;  ///< [m]
  double yaw = 0;       ///< [rad]
  double score = 0;     ///< log-likelihood ratio against chance [nats]
};

/// What a user may know beforehand about the pose of the last query frame.
struct PlacePrior {
  struct Circle {
    double x = 0, y = 0, radius = 0;  ///< [m], map frame
  };
  struct Heading {
    double yaw = 0, tolerance = 0;  ///< [rad], map frame
  };
  std::optional<Circle> near;
  std::optional<Heading> heading;
};

/// How many times as long a length of the map may be as it is in the query.
struct ScaleRange {
  double low = 1, high = 1;
};

/// Poses this near to one another are the same place for the verdict.
constexpr double kSamePlace_m = 8, kSamePlace_rad = 0.4;
/// Neither farther away nor turned by more than that.
bool samePlace(const PlacePose& a, const PlacePose& b);

}  // namespace xview
