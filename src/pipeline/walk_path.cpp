// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/walk_path.h"

#include <algorithm>
#include <cmath>

#include "pipeline/set_verdict.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr int kWalkPlaces = 3;  ///< poses that walks may propose

/// Query vertices that a wrong pose would bring to agreement by chance: each has some candidates
/// anywhere in the map.
double chanceInliers(const std::vector<Correspondence>& putative, const SemanticGraph& map,
                     double inlier_m) {
  if (map.empty()) return 0;
  Eigen::Vector2d low = map.vertices[0].position.head<2>(), high = low;
  for (const Vertex& v : map.vertices) {
    low = low.cwiseMin(v.position.head<2>());
    high = high.cwiseMax(v.position.head<2>());
  }
  const double area = std::max(1.0, (high - low).prod());
  return static_cast<double>(putative.size()) * M_PI * inlier_m * inlier_m / area;
}

/// Inliers of the first pose that is another one than the first: the query may be tilted, so turns
/// about any axis count.
int runnerUp(const std::vector<WalkProposal>& poses, const Eigen::Vector3d& sensor) {
  constexpr double kOther_m = 8, kOther_rad = 0.4;
  for (const WalkProposal& p : poses) {
    const double apart_m = (p.T_map_query * sensor - poses[0].T_map_query * sensor).norm();
    if (apart_m >= kOther_m || rotationBetween(p.T_map_query, poses[0].T_map_query) >= kOther_rad)
      return static_cast<int>(p.inliers.size());
  }
  return 0;
}

}  // namespace

void WalkPath::localize(const Query& query, const Priors& priors, Localization& answer) const {
  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  WalkProposals result =
      walks_.propose(walk_query, kWalkPlaces, query.gravity.known ? UpKnown::yes : UpKnown::no);
  result.poses.erase(std::remove_if(result.poses.begin(), result.poses.end(),
                                    [&](const WalkProposal& p) {
                                      return !satisfies(priors, query, p.T_map_query);
                                    }),
                     result.poses.end());
  answer.putative = result.putative;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  answer.matches = static_cast<int>(result.putative.size());
  answer.timing_ms.emplace_back("descriptors", result.descriptors_ms);
  answer.timing_ms.emplace_back("matching", result.matching_ms);
  answer.timing_ms.emplace_back("rejection", result.rejection_ms);
  answer.timing_ms.emplace_back("pose", result.pose_ms);
  for (const WalkProposal& p : result.poses) {
    const auto inliers = static_cast<int>(p.inliers.size());
    answer.hypotheses.push_back(
        {p.T_map_query, static_cast<double>(inliers), inliers, Proposer::walks});
  }
  ConsensusEvidence evidence;
  evidence.vertices = answer.vertices;
  evidence.chance_inliers = chanceInliers(result.putative, map_.graph, options_.consensus.inlier_m);
  if (!result.poses.empty()) {
    answer.kept = result.poses[0].inliers;
    evidence.inliers = answer.inliers = static_cast<int>(answer.kept.size());
    evidence.runner_up = runnerUp(result.poses, query.poses.back().translation());
  }
  setVerdict(judge(evidence, options_.verdict), answer);
}

}  // namespace xview
