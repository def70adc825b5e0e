// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "xview/match/plan_field.h"
#include "xview/match/plan_places.h"

namespace xview {

/// Log ratios times the weight of a sample of the channel.
struct WeightedRatios {
  std::array<std::array<float, kDistanceBins + 1>, kChannels> value{};
  std::array<float, kChannels> expected{};
};

/// Score of gravity-aligned poses of the query centre in plan coordinates.
class PlanScore {
 public:
  PlanScore(const PlanField& field, const WeightedRatios& ratios,
            const std::vector<PlanQuery::Sample>& samples);

  double operator()(double x, double y, double yaw) const;
  /// Pattern search: steps of `step_m` and `step_rad`, halved `levels - 1` times.
  PlacePose climb(PlacePose start, double step_m, double step_rad, int levels) const;

 private:
  const PlanField& field_;
  const WeightedRatios& ratios_;
  const std::vector<PlanQuery::Sample>& samples_;
  double radius_m_;
};

/// The distance class of each sample at a pose of the query centre.
std::vector<std::uint8_t> distanceBins(const PlanField& field,
                                       const std::vector<PlanQuery::Sample>& samples,
                                       const PlacePose& pose);

/// What a score is made of.
struct ScoreDetails {
  double expected = 0;
  double known_share = 0;
  PlanPart standing;
  std::array<PlanPart, 2> sides;
  int objects = 0, objects_matched = 0;
};
ScoreDetails scoreDetails(const PlanField& field, const WeightedRatios& ratios,
                          const std::vector<PlanQuery::Sample>& samples, const PlacePose& pose);

}  // namespace xview
