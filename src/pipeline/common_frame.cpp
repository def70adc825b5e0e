// SPDX-License-Identifier: BSD-3-Clause
#include "xview/common_frame.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "xview/localizer.h"

namespace xview {
namespace {

constexpr double kEnough_nats = 10;  ///< for or against: a few things that both have seen
constexpr double kReach_m = 5;       ///< of a town; the climb of a search ends about there

/// What the user believes about queries says nothing about maps, and bare walks judge no pose.
Options plainSearch(Options options) {
  options.method = "search";
  options.scale.clear();
  options.prior = {};
  return options;
}

double areaOf(const PlanView& plan) {
  return plan.cell_m * plan.cell_m * static_cast<double>(plan.known.size());
}

/// From one key frame to the next of a drive, wherever that lies.
struct Step {
  double length_m, until_s;
};

/// One list per source.
std::vector<std::vector<Step>> stepsOf(const map::SemanticMap& map) {
  std::vector<std::vector<Step>> steps(map.sources.size());
  for (std::size_t i = 1; i < map.poses.size(); ++i) {
    if (map.source_of_pose[i] != map.source_of_pose[i - 1]) continue;
    const double length_m = (map.poses[i].translation() - map.poses[i - 1].translation()).norm();
    steps[map.source_of_pose[i]].push_back({length_m, map.stamps_s[i]});
  }
  return steps;
}

/// Simulated drives make the same steps, but at another time.
bool areSameSteps(const std::vector<Step>& a, const std::vector<Step>& b) {
  constexpr std::size_t kFewest = 3;
  constexpr double kExact = 1e-5;
  const std::size_t both = std::min(a.size(), b.size());
  return both >= kFewest && std::equal(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(both),
                                       b.begin(), [&](const Step& x, const Step& y) {
                                         return std::abs(x.length_m - y.length_m) < kExact &&
                                                std::abs(x.until_s - y.until_s) < kExact;
                                       });
}

}  // namespace

std::optional<FrameEvidence> evidenceOfOneFrame(const map::SemanticMap& map,
                                                const map::SemanticMap& other,
                                                const Options& options) {
  if (map.size != other.size) return std::nullopt;
  const Localizer localizer(map, plainSearch(options));
  const Query query = makeQuery(other, options);
  const std::vector<Eigen::Isometry3d> as_it_is{Eigen::Isometry3d::Identity()};
  const verify::Evidence here = localizer.check(query, as_it_is, 0)[0].evidence;
  if (std::abs(here.score) < kEnough_nats) return std::nullopt;
  const PoseCheck best = localizer.check(query, as_it_is, kReach_m * map.size)[0];
  const Eigen::Vector3d sensor = query.poses.back().translation();
  return FrameEvidence{here.score, here.expected, best.evidence.score,
                       (best.T_map_query * sensor - sensor).norm(),
                       here.known_share * areaOf(other.plan)};
}

bool holdsSameDrive(const map::SemanticMap& map, const map::SemanticMap& other) {
  const auto steps = stepsOf(map);
  for (const std::vector<Step>& added : stepsOf(other)) {
    for (const std::vector<Step>& there : steps) {
      if (areSameSteps(added, there)) return true;
    }
  }
  return false;
}

}  // namespace xview
