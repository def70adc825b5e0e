// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/match/plan_places.h"

namespace xview {

/// The exhaustive search takes time with the third power of the radius of a query: finer steps of
/// yaw, more samples, more poses at which some of them meet the map. A query wider than
/// kWidest_m is therefore searched for by its densest part, and the poses found are climbed with
/// ever more of the query around that part.
constexpr double kWidest_m = 200, kPart_m = 150;

/// A part of a query about a centre of its own.
struct QueryPart {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< of its centre from that of the query
  std::vector<PlanQuery::Sample> samples;            ///< about its centre
};

/// Those within `radius_m` of `centre`, in their order.
QueryPart partAround(const std::vector<PlanQuery::Sample>& samples, const Eigen::Vector2d& centre,
                     double radius_m);

/// The disc of `radius_m`, about the mean of the samples in some square, that holds most samples.
QueryPart densestPart(const std::vector<PlanQuery::Sample>& samples, double radius_m);

/// A prior of the centre of a query as one of the centre of a part: never narrower.
PlacePrior priorOfPart(PlacePrior prior, const QueryPart& part);

}  // namespace xview
