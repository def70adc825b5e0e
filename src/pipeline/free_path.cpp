// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/free_path.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/gravity.h"
#include "pipeline/upright_frame.h"
#include "xview/types/pose.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr int kWalkPoses = 6;        ///< that may say where up is
constexpr double kSameUp_rad = 0.1;  ///< the search bears an error of so much

void addIfNew(const Eigen::Vector3d& up, std::vector<Eigen::Vector3d>& ups) {
  const auto known = [&](const Eigen::Vector3d& other) {
    return other.dot(up) > std::cos(kSameUp_rad);
  };
  if (std::none_of(ups.begin(), ups.end(), known)) ups.push_back(up);
}

double scoreOf(const ObjectSearchResult& result) {
  return result.hypotheses.empty() ? 0 : result.hypotheses[0].score;
}

std::size_t bestOf(const std::vector<ObjectSearchResult>& found) {
  const auto worse = [](const ObjectSearchResult& a, const ObjectSearchResult& b) {
    return scoreOf(a) < scoreOf(b);
  };
  return static_cast<std::size_t>(std::max_element(found.begin(), found.end(), worse) -
                                  found.begin());
}

bool isOnePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
               const Eigen::Vector3d& sensor) {
  constexpr double kOther_m = 8, kOther_rad = 0.4;
  return (a * sensor - b * sensor).norm() < kOther_m && rotationBetween(a, b) < kOther_rad;
}

/// What another way up found speaks against the best one, unless it is the same pose.
void addRivals(const ObjectSearchResult& other, const Eigen::Quaterniond& R_other_best,
               const Eigen::Vector3d& sensor, ObjectSearchResult& result) {
  if (result.hypotheses.empty()) return;
  result.poses += other.poses;
  for (ObjectHypothesis h : other.hypotheses) {
    h.T_map_query = h.T_map_query * R_other_best;
    if (isOnePose(h.T_map_query, result.hypotheses[0].T_map_query, sensor)) continue;
    result.wrong.best = result.wrong.count == 0 ? h.score : std::max(result.wrong.best, h.score);
    result.wrong.count = std::max(1, result.wrong.count);
    const auto at =
        std::find_if(result.hypotheses.begin() + 1, result.hypotheses.end(),
                     [&](const ObjectHypothesis& known) { return known.score < h.score; });
    result.hypotheses.insert(at, std::move(h));
  }
}

}  // namespace

Eigen::Quaterniond FreePath::localize(const Query& query, const Priors& priors,
                                      Localization& answer) const {
  Stopwatch watch;
  std::vector<Eigen::Vector3d> ups;
  const Eigen::Vector3d normal = layerNormal(query.graph);
  if (normal.norm() > 0) {
    addIfNew(normal, ups);
    addIfNew(-normal, ups);
  }
  const WalkProposals walked =
      walks_.propose(walks_.queryGraph(query.graph), kWalkPoses, UpKnown::no);
  for (const WalkProposal& p : walked.poses)
    addIfNew(p.T_map_query.linear().transpose() * Eigen::Vector3d::UnitZ(), ups);
  answer.putative = walked.putative;
  answer.timing_ms.emplace_back("descriptors", walked.descriptors_ms);
  answer.timing_ms.emplace_back("rejection", watch.lap_ms() - walked.descriptors_ms);

  std::vector<ObjectSearchResult> found;
  for (const Eigen::Vector3d& up : ups)
    found.push_back(objects_.search(uprightQuery(query, uprightBy(up)), priors));
  const std::size_t best = bestOf(found);
  const Eigen::Quaterniond upright =
      found.empty() ? Eigen::Quaterniond::Identity() : uprightBy(ups[best]);
  ObjectSearchResult result = found.empty() ? ObjectSearchResult() : found[best];
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i != best)
      addRivals(found[i], uprightBy(ups[i]) * upright.conjugate(),
                upright * query.poses.back().translation(), result);
  }
  objects_.report(result, answer);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  return upright;
}

}  // namespace xview
