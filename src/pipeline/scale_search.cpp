// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/scale_search.h"

#include <algorithm>
#include <cmath>

#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr double kStep =
    0.06;  ///< a window of 60 m then fits within 1 m at its ends for one of the scales
constexpr std::size_t kClimbed = 3;  ///< best scales that are climbed from

struct Candidate {
  double scale = 1;
  PoseCheck place;
  double score() const { return place.evidence.score; }
};

std::vector<double> scalesIn(const ScaleRange& range) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil(std::log(range.high / range.low) / kStep)));
  std::vector<double> scales;
  for (int i = 0; i <= steps; ++i)
    scales.push_back(range.low * std::pow(range.high / range.low, static_cast<double>(i) / steps));
  return scales;
}

/// The middle of what was seen, which a change of the scale should leave where it is.
Eigen::Vector3d middleOf(const Query& query) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Vertex& v : query.graph.vertices) sum += v.position;
  return query.graph.empty() ? query.poses.back().translation()
                             : Eigen::Vector3d(sum / static_cast<double>(query.graph.size()));
}

Candidate climbed(const Query& query, const ScaleRange& range, const ScaleProbe& probe,
                  Candidate best) {
  const Eigen::Vector3d middle = middleOf(query);
  for (double step = kStep / 3; step > 0.002; step /= 2) {
    for (bool moved = true; moved;) {
      moved = false;
      for (const double factor : {1 + step, 1 / (1 + step)}) {
        Candidate next;
        next.scale = std::clamp(best.scale * factor, range.low, range.high);
        if (next.scale == best.scale) continue;
        Eigen::Isometry3d T = best.place.T_map_query;
        T.translation() += T.linear() * ((best.scale - next.scale) * middle);
        next.place = probe.climb(scaledQuery(query, next.scale), T);
        if (next.score() <= best.score()) continue;
        best = next;
        moved = true;
        break;
      }
    }
  }
  return best;
}

bool isElsewhere(const Query& query, const Candidate& a, const Candidate& b) {
  constexpr double kOther_m = 8, kOther_rad = 0.4;
  const Eigen::Vector3d middle = middleOf(query);
  return (a.place.T_map_query * (a.scale * middle) - b.place.T_map_query * (b.scale * middle))
                 .norm() > kOther_m ||
         rotationBetween(a.place.T_map_query, b.place.T_map_query) > kOther_rad;
}

}  // namespace

Query scaledQuery(const Query& query, double scale) {
  Query scaled = query;
  for (Vertex& v : scaled.graph.vertices) {
    v.position *= scale;
    v.extent *= scale;
    v.sigma_m *= scale;
  }
  const auto factor = static_cast<float>(scale);
  PlanView& plan = scaled.plan;
  plan.cell_m *= scale;
  plan.origin_x *= scale;
  plan.origin_y *= scale;
  plan.origin_z *= scale;
  for (auto& channel : plan.samples) {
    for (PlanSample& s : channel) s = {factor * s.x, factor * s.y, factor * s.z};
  }
  for (GroundCell& cell : plan.known) cell.z *= factor;
  scaled.cloud.origin *= scale;
  for (Point& p : scaled.cloud.points) {
    p.getVector3fMap() *= factor;
    p.sigma *= factor;
  }
  scaled.cloud_sigma_m *= scale;
  for (Eigen::Isometry3d& T : scaled.poses) T.translation() *= scale;
  return scaled;
}

FoundScale findScale(const Query& query, const ScaleRange& range, const ScaleProbe& probe) {
  std::vector<Candidate> candidates;
  for (const double scale : scalesIn(range))
    candidates.push_back({scale, probe.search(scaledQuery(query, scale))});
  const auto better = [](const Candidate& a, const Candidate& b) { return a.score() > b.score(); };
  std::stable_sort(candidates.begin(), candidates.end(), better);
  for (std::size_t i = 0; i < std::min(kClimbed, candidates.size()); ++i) {
    if (candidates[i].score() > 0) candidates[i] = climbed(query, range, probe, candidates[i]);
  }
  std::stable_sort(candidates.begin(), candidates.end(), better);
  FoundScale found{candidates[0].scale, 0};
  for (const Candidate& c : candidates) {
    if (c.score() > found.rival_score && isElsewhere(query, c, candidates[0]))
      found.rival_score = c.score();
  }
  return found;
}

}  // namespace xview
