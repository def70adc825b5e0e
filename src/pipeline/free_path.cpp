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

double scoreOf(const search::SearchResult& result) {
  return result.places.empty() ? 0 : result.places[0].score();
}

std::size_t bestOf(const std::vector<search::SearchResult>& found) {
  const auto worse = [](const search::SearchResult& a, const search::SearchResult& b) {
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

/// What another way up found speaks against the best one, unless it is the same pose. Only places
/// that were described have a pose in space.
void addRivals(const search::SearchResult& other, std::size_t described,
               const Eigen::Quaterniond& R_other_best, const Eigen::Vector3d& sensor,
               search::SearchResult& result) {
  if (result.places.empty()) return;
  result.poses += other.poses;
  for (std::size_t i = 0; i < std::min(described, other.places.size()); ++i) {
    search::PlaceHypothesis h = other.places[i];
    h.T_map_query = h.T_map_query * R_other_best;
    if (isOnePose(h.T_map_query, result.places[0].T_map_query, sensor)) continue;
    const auto at = std::find_if(
        result.places.begin() + 1, result.places.end(),
        [&](const search::PlaceHypothesis& known) { return known.score() < h.score(); });
    result.places.insert(at, std::move(h));
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

  std::vector<search::SearchResult> found;
  for (const Eigen::Vector3d& up : ups)
    found.push_back(objects_.search(uprightQuery(query, uprightBy(up)), priors));
  const std::size_t best = bestOf(found);
  const Eigen::Quaterniond upright =
      found.empty() ? Eigen::Quaterniond::Identity() : uprightBy(ups[best]);
  search::SearchResult result = found.empty() ? search::SearchResult() : found[best];
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i != best)
      addRivals(found[i], static_cast<std::size_t>(options_.places.hypotheses),
                uprightBy(ups[i]) * upright.conjugate(), upright * query.poses.back().translation(),
                result);
  }
  objects_.report(result, 0, answer);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  return upright;
}

}  // namespace xview
