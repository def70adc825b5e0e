// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "search/surface_query.h"

namespace xview::search {

/// Height of a place of the map above the place of the query that a pose puts there.
struct HeightPair {
  double x = 0, y = 0;  ///< from the centre of the query [m]
  double rise = 0;      ///< [m]
  double sigma = 0.5;   ///< of the rise of a true pair [m]
  double weight = 1;    ///< in heightCost()
};

/// How a plane through the rises is fitted.
struct HeightModel {
  double slope_sigma = 0;     ///< how far off level the query may be [m/m]
  std::size_t fewest = 0;     ///< pairs that tell a slope
  double last_gate = 0;       ///< residuals that count in full at last [sigma]
  double alike = 1;           ///< number of neighbouring pairs whose errors are common
  double least_variance = 1;  ///< of a pair [sigma^2]; more if the residuals say so
};

/// Cells of ground, whose sigma is 1 m: roads are smooth, and so is drift.
HeightModel groundHeights(double slope_sigma);
/// Vertices of bare graphs. Gravity is known to a degree or two.
HeightModel vertexHeights();

double medianRise(const std::vector<HeightPair>& pairs);

/// Robust plane: least squares with weights of Geman-McClure, whose gate narrows (graduated
/// non-convexity), and with slopes near zero. With fewer pairs than tell a slope it is level, at
/// the median, and its `cells` are 0.
HeightFit fitHeights(const std::vector<HeightPair>& pairs, const HeightModel& model);

/// What a tilt and heights off the plane speak against a place [nats]: robust, 0 if all agree.
double heightCost(const std::vector<HeightPair>& pairs, const HeightFit& fit);

/// Measured ground of the map above that of a query, at a pose of its centre in plan coordinates.
std::vector<HeightPair> groundPairs(const DistanceField& field,
                                    const std::vector<SurfaceSamples::Ground>& ground,
                                    const PlacePose& pose);

/// Median height of the map, relative to the origin of its plan, above a query at such a pose.
/// Where no measured ground of both meets, the ground below their samples is compared, known only
/// from what stands on it; 0 if they do not meet at all.
double heightOffset(const DistanceField& field, const SurfaceSamples& samples,
                    const PlacePose& pose);

}  // namespace xview::search
