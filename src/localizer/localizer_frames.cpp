// SPDX-License-Identifier: BSD-3-Clause
// Which way is up in a query and how long its metre is: what is known, or what finds the best
// place.
#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "localizer/level_on_map.h"
#include "localizer/localizer_index.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr int kWalkUps = 6;              ///< poses that walks propose for the gravity alignment
constexpr double kBearableUp_rad = 0.1;  ///< error of up that the search bears
constexpr std::size_t kRefinedScales = 3;

/// Frames differ, so poses are compared by what they do to the middle of the query.
bool isOtherPlace(const Query& query, const TriedFrame& a, const TriedFrame& b) {
  const Eigen::Vector3d middle = middleOf(query);
  const auto placed = [&](const TriedFrame& t) -> Eigen::Vector3d {
    return t.T_map_query * (t.guess.R_up * (t.guess.scale * middle));
  };
  const auto turned = [](const TriedFrame& t) { return t.T_map_query * t.guess.R_up; };
  return (placed(a) - placed(b)).norm() >= kSamePlace_m ||
         rotationBetween(turned(a), turned(b)) >= kSamePlace_rad;
}

}  // namespace

Eigen::Quaterniond PlaceIndex::alignmentOf(const Query& query,
                                           const Eigen::Isometry3d& T_map_query) const {
  if (upIsKnown(query)) return query.gravity.alignment;
  return alignmentFromUp(T_map_query.linear().transpose() *
                         (gravity.alignment.conjugate() * Eigen::Vector3d::UnitZ()));
}

Eigen::Isometry3d PlaceIndex::toAligned(const Query& query,
                                        const Eigen::Isometry3d& T_map_query) const {
  const Eigen::Quaterniond R_up = alignmentOf(query, T_map_query);
  return alignedAbout(R_up * query.poses.back().translation(),
                      gravity.alignment * T_map_query * R_up.conjugate());
}

/// Which way up and how long a metre is: what is known, or what finds the best place.
FrameHypothesis PlaceIndex::chooseFrame(const Query& query, const ExpectedPose* expected,
                                        double& second_best_score, Timings& timing_ms) const {
  const std::vector<FrameHypothesis> guesses = frameHypotheses(query, expected, timing_ms);
  if (guesses.size() == 1) return guesses[0];
  Stopwatch watch;
  std::vector<TriedFrame> all;
  for (const FrameHypothesis& guess : guesses) all.push_back(tried(query, guess, expected));
  const auto better = [](const TriedFrame& a, const TriedFrame& b) { return a.score > b.score; };
  std::stable_sort(all.begin(), all.end(), better);
  if (scales) {
    for (std::size_t i = 0; i < std::min(kRefinedScales, all.size()); ++i)
      refineScale(query, all[i]);
    std::stable_sort(all.begin(), all.end(), better);
  }
  for (const TriedFrame& other : all) {
    if (isOtherPlace(query, other, all[0]))
      second_best_score = std::max(second_best_score, other.score);
  }
  timing_ms.emplace_back(scales ? "scale" : "up", watch.lap_ms());
  return all[0].guess;
}

/// All that may be. Poses with six degrees of freedom from walks and the maximum clique, and the
/// two sides of the layer that the vertices form, say where an unknown up may be.
std::vector<FrameHypothesis> PlaceIndex::frameHypotheses(const Query& query,
                                                         const ExpectedPose* expected,
                                                         Timings& timing_ms) const {
  std::vector<Eigen::Vector3d> ups;
  const auto add = [&](const Eigen::Vector3d& up) {
    const auto same = [&](const Eigen::Vector3d& u) {
      return u.dot(up) > std::cos(kBearableUp_rad);
    };
    if (std::none_of(ups.begin(), ups.end(), same)) ups.push_back(up);
  };
  if (expected) {
    add(alignmentOf(query, expected->T_map_query).conjugate() * Eigen::Vector3d::UnitZ());
  } else if (upIsKnown(query) || !method.scores_poses) {
    add(query.gravity.alignment.conjugate() * Eigen::Vector3d::UnitZ());
  } else {
    const Eigen::Vector3d normal = layerNormal(query.graph);
    if (normal.norm() > 0) {
      add(normal);
      add(-normal);
    }
    const match::WalkMatches walked =
        walks.matchEverywhere(walks.queryGraph(query.graph), kWalkUps, false, timing_ms);
    for (const match::MatchedPose& pose : walked.poses)
      add(pose.T_map_query.linear().transpose() * Eigen::Vector3d::UnitZ());
    if (ups.empty()) add(Eigen::Vector3d::UnitZ());
  }
  if (scales && !method.scores_poses)
    throw UsageError("scale = " + options.scale +
                     " needs the place search; method = walks has none");
  std::vector<FrameHypothesis> guesses;
  for (const double scale : scales ? scalesIn(*scales) : std::vector<double>{1}) {
    for (const Eigen::Vector3d& up : ups) {
      const bool given = upIsKnown(query) || !method.scores_poses;
      guesses.push_back({given ? query.gravity.alignment : alignmentFromUp(up), scale});
    }
  }
  return guesses;
}

/// The best place of a search with one guess.
TriedFrame PlaceIndex::tried(const Query& given, const FrameHypothesis& guess,
                             const ExpectedPose* expected) const {
  TriedFrame frame{guess, Eigen::Isometry3d::Identity(), 0};
  const AlignedQuery query(given, guess);
  Timings unused;
  const Candidates found = proposer->propose(*query, priorsOf(given, *query, expected), unused);
  if (found.places.empty()) return frame;
  frame.T_map_query = found.places[0].T_map_query;
  frame.score = found.places[0].score();
  return frame;
}

/// To the best scale and pose around, by turns.
void PlaceIndex::refineScale(const Query& given, TriedFrame& best) const {
  if (best.score <= 0) return;
  const Eigen::Vector3d middle = best.guess.R_up * middleOf(given);
  for (double step = kScaleStep / 3; step > 0.002; step /= 2) {
    for (bool moved = true; moved;) {
      moved = false;
      askBudget("the scale");
      for (const double factor : {1 + step, 1 / (1 + step)}) {
        TriedFrame next = best;
        next.guess.scale = std::clamp(best.guess.scale * factor, scales->low, scales->high);
        if (next.guess.scale == best.guess.scale) continue;
        next.T_map_query.translation() +=
            next.T_map_query.linear() * ((best.guess.scale - next.guess.scale) * middle);
        const AlignedQuery query(given, next.guess);
        const auto in_field = fields.prepare(*query);
        const search::PlaceHypothesis place = in_field->verify(next.T_map_query);
        if (place.score() <= best.score) continue;
        next.T_map_query = place.T_map_query;
        next.score = place.score();
        best = next;
        moved = true;
        break;
      }
    }
  }
}

/// Hypotheses, pose and covariance in the frames of map and query, and what was assumed about up.
void PlaceIndex::leaveAlignedFrames(const Query& query, const FrameHypothesis& frame,
                                    Localization& answer) const {
  const bool was_turned = gravity.turned() || query.gravity.turned();
  if (answer.gravity == GravityUse::aligned && was_turned) answer.gravity = GravityUse::levelled;
  answer.gravity_reason =
      "query: " + query.gravity.reason + "; map: " + gravity.reason + answer.gravity_reason;
  const Eigen::Isometry3d T_map_aligned(gravity.alignment.conjugate());
  for (Hypothesis& h : answer.hypotheses)
    h.T_map_query = T_map_aligned * h.T_map_query * frame.R_up;
  if (answer.hypotheses.empty()) return;
  answer.T_map_query = answer.hypotheses[0].T_map_query;
  Eigen::Isometry3d last = query.poses.back();
  last.translation() *= answer.scale;
  answer.T_map_sensor = answer.T_map_query * last;
  Matrix6d turned_back = Matrix6d::Zero();
  turned_back.topLeftCorner<3, 3>() = turned_back.bottomRightCorner<3, 3>() =
      T_map_aligned.linear();
  answer.covariance = turned_back * answer.covariance * turned_back.transpose();
  // The posterior bends the way; the registration moves its end, and all of it follows.
  if (answer.trajectory.empty()) return;
  const Eigen::Isometry3d move =
      answer.T_map_sensor * (T_map_aligned * answer.trajectory.back()).inverse() * T_map_aligned;
  for (Eigen::Isometry3d& T : answer.trajectory) T = move * T;
}

}  // namespace xview
