// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sequence.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "base/pose.h"
#include "place/storeys.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"

namespace xview {
namespace {

// Windows that are remembered; each of them is asked about every new place.
constexpr std::size_t kWindows = 12;
// Places that are followed through them, the best ones.
constexpr std::size_t kPlaces = 40;
// A place of a town may move so far from one window to the next [m], besides the drift of the
// odometry.
constexpr double kStretchReach_m = 1.5;

/// A query and its frames [first, last) of the recording.
struct Window {
  Query query;
  std::size_t first = 0, last = 0;

  Eigen::Vector3d sensor() const { return query.poses.back().translation(); }
};

/// One place, as each window of the history sees it.
struct Track {
  std::vector<PoseCheck> seen;  ///< by window; with dense evidence once it was verified densely
  PlaceEvidence sum;            ///< over the windows that count
};

/// Score of a window over that of a true pose; nothing where the map was hardly seen.
std::optional<double> scoreShare(const PlaceEvidence& e, const verdict::VerdictOptions& o) {
  if (!(e.expected > 0) || e.map_coverage < o.min_known_share) return std::nullopt;
  return e.score / e.expected;
}
constexpr double kAgrees = 0.4, kContradicts = 0.2;  ///< shares: at least, below

template <class Evidence>
std::optional<double> meanOf(const std::vector<DenseEvidence>& looks,
                             std::optional<double> Evidence::*what) {
  double sum = 0;
  int asked = 0;
  for (const DenseEvidence& look : looks) {
    if (!(look.*what)) continue;
    sum += *(look.*what);
    ++asked;
  }
  return asked > 0 ? std::optional(sum / asked) : std::nullopt;
}

/// Mean of the dense evidence of the windows at one place. A window whose registration did not
/// converge has the null inlier ratio; the rest is that of the newest window, the last one.
DenseEvidence meanOf(const std::vector<DenseEvidence>& looks) {
  DenseEvidence mean = looks.back();
  mean.inlier_ratio = mean.null_inlier_ratio = 0;
  for (const DenseEvidence& look : looks) {
    mean.inlier_ratio += look.inlier_ratio / static_cast<double>(looks.size());
    mean.null_inlier_ratio += look.null_inlier_ratio / static_cast<double>(looks.size());
  }
  for (const auto what : {&Visibility::conflict_ratio, &Visibility::obstacle_overlap,
                          &Visibility::map_overlap, &Visibility::miss_ratio})
    mean.*what = meanOf(looks, what);
  for (const auto what : {&DenseEvidence::self_consistency, &DenseEvidence::free_space_violation})
    mean.*what = meanOf(looks, what);
  return mean;
}

void sumUp(const PartEvidence& part, PartEvidence& sum) {
  sum.score += part.score;
  sum.expected += part.expected;
}

}  // namespace

struct Sequence::State {
  State(const Localizer& l, const Options& o) : localizer(l), options(o) {}

  SequenceAnswer add(const Query& query, std::size_t first, std::size_t last) {
    SequenceAnswer answer;
    if (!query.jumps.empty()) forget();  // nothing connects it with earlier windows
    answer.alone = answer.fix = localizer.localize(query);
    if (isBudgetSpent()) return answer;
    remember(query, first, last);
    follow();
    begin(answer.alone.hypotheses);
    if (tracks.empty()) return answer;
    sumEvidence();
    judgeSum(answer);
    if (bestIsThatOf(answer.alone))
      tracks.front().seen.back().evidence.dense = answer.alone.statistics.dense;
    if (answer.windows < 2) return answer;
    if (answer.alone.accepted() && !bestIsThatOf(answer.alone) && !bestFitsNewest())
      restart(answer);
    else
      decide(query, answer);
    return answer;
  }

  void forget() {
    windows.clear();
    tracks.clear();
  }

  void remember(const Query& query, std::size_t first, std::size_t last) {
    windows.push_back({query, first, last});
    if (windows.size() <= kWindows) return;
    windows.pop_front();
    for (Track& track : tracks) track.seen.erase(track.seen.begin());
  }

  /// Asks the newest window about the places known so far.
  void follow() {
    if (windows.size() < 2) return;
    std::vector<Eigen::Isometry3d> poses;
    for (const Track& track : tracks) poses.push_back(track.seen.back().T_map_query);
    const std::size_t newest = windows.size() - 1;
    const std::vector<PoseCheck> places =
        localizer.check(windows[newest].query, poses, reachBetween(newest, newest - 1));
    for (std::size_t i = 0; i < tracks.size(); ++i) tracks[i].seen.push_back(places[i]);
  }

  /// Hypotheses of the newest window that no track has, with what the earlier windows say about
  /// them.
  void begin(const std::vector<Hypothesis>& hypotheses) {
    const std::size_t newest = windows.size() - 1;
    std::vector<Eigen::Isometry3d> poses;
    for (const Hypothesis& h : hypotheses) poses.push_back(h.T_map_query);
    for (PoseCheck& place :
         localizer.check(windows[newest].query, poses, kStretchReach_m * localizer.size())) {
      const auto same = std::find_if(tracks.begin(), tracks.end(), [&](const Track& t) {
        return isSamePlace(t.seen.back(), place);
      });
      if (same == tracks.end()) {
        Track track;
        track.seen.assign(windows.size(), place);
        tracks.push_back(std::move(track));
      } else if (place.evidence.score > same->seen.back().evidence.score) {
        same->seen.back() = place;
        continue;
      } else {
        continue;
      }
      std::vector<PoseCheck>& seen = tracks.back().seen;
      for (std::size_t w = newest; w-- > 0;) {
        seen[w] =
            localizer.check(windows[w].query, {seen[w + 1].T_map_query}, reachBetween(w + 1, w))[0];
      }
    }
  }

  void sumEvidence() {
    const std::vector<bool> counts = counted();
    const auto number = static_cast<double>(std::count(counts.begin(), counts.end(), true));
    for (Track& track : tracks) {
      track.sum = {};
      track.sum.map_coverage = 0;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        if (!counts[w]) continue;
        const PlaceEvidence& e = track.seen[w].evidence;
        track.sum.score += e.score;
        track.sum.expected += e.expected;
        track.sum.of_surfaces = e.of_surfaces;
        track.sum.map_coverage += e.map_coverage / number;
        sumUp(e.obstacles, track.sum.obstacles);
      }
    }
    std::stable_sort(tracks.begin(), tracks.end(),
                     [](const Track& a, const Track& b) { return a.sum.score > b.sum.score; });
    std::vector<Track> kept;
    for (Track& track : tracks) {  // tracks that have met are one place now
      if (kept.size() >= kPlaces) break;
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const Track& k) {
        return isSamePlace(k.seen.back(), track.seen.back());
      });
      if (!known) kept.push_back(std::move(track));
    }
    tracks = std::move(kept);
  }

  /// From the newest window back, every window that shares no frame with a later one.
  std::vector<bool> counted() const {
    std::vector<bool> counts(windows.size(), false);
    std::size_t first = windows.back().last;
    for (std::size_t w = windows.size(); w-- > 0;) {
      if (windows[w].last > first) continue;
      counts[w] = true;
      first = windows[w].first;
    }
    return counts;
  }

  /// Odometry drifts between windows, so a place may move a little against it.
  double reachBetween(std::size_t a, std::size_t b) const {
    return kStretchReach_m * localizer.size() +
           options.odometry.drift * (windows[a].sensor() - windows[b].sensor()).norm();
  }

  /// Where the place has the last sensor, in canonical lengths. Origins of query frames lie
  /// anywhere, so their poses cannot be compared.
  PlacePose placeNow(const PoseCheck& place) const {
    const Eigen::Vector3d p = place.T_map_query * windows.back().sensor() / localizer.size();
    return {p.x(), p.y(), yawOf(place.T_map_query.linear()), 0};
  }

  /// Two tracks are one if the newest window sees them at one pose.
  bool isSamePlace(const PoseCheck& a, const PoseCheck& b) const {
    return samePlace(placeNow(a), placeNow(b)) && !areOnTwoStoreys(a, b);
  }

  double heightBetween(const PoseCheck& a, const PoseCheck& b) const {
    const Eigen::Vector3d sensor = windows.back().sensor();
    return (a.T_map_query * sensor - b.T_map_query * sensor).z();
  }
  bool areOnTwoStoreys(const PoseCheck& a, const PoseCheck& b) const {
    return localizer.size() < kTownScale && std::abs(heightBetween(a, b)) > kLowestStorey_m;
  }

  void judgeSum(SequenceAnswer& answer) const {
    const std::vector<bool> counts = counted();
    answer.windows = static_cast<int>(std::count(counts.begin(), counts.end(), true));
    answer.score = tracks.front().sum.score;
    answer.runner_up = tracks.size() > 1 ? std::max(0.0, tracks[1].sum.score) : 0;
  }

  /// True if the best place is that of the newest window by itself.
  bool bestIsThatOf(const Localization& alone) const {
    return !alone.hypotheses.empty() &&
           isSamePlace(tracks.front().seen.back(), {alone.T_map_query, {}});
  }

  bool bestFitsNewest() const {
    return scoreShare(tracks.front().seen.back().evidence, options.verdict) >= kAgrees;
  }

  /// Forgets all windows but the newest.
  void restart(SequenceAnswer& answer) {
    answer.restarted = true;
    windows.erase(windows.begin(), windows.end() - 1);
    for (Track& track : tracks) track.seen.erase(track.seen.begin(), track.seen.end() - 1);
    sumEvidence();
    judgeSum(answer);
  }

  /// What the newest window says at the best place.
  Localization atBest(const Query& query, const SequenceAnswer& answer) const {
    if (bestIsThatOf(answer.alone)) return answer.alone;
    Localization described = localizer.describe(query, tracks.front().seen.back());
    described.vertices = answer.alone.vertices;
    described.matches = answer.alone.matches;
    return described;
  }

  /// Mean dense evidence of a track over the windows that count: an out-of-map query may fit by its
  /// newest window only.
  DenseEvidence verifyDensely(Track& track) const {
    const std::vector<bool> counts = counted();
    std::vector<DenseEvidence> looks;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      if (!counts[w]) continue;
      DenseEvidence& look = track.seen[w].evidence.dense;
      if (!look.registered())
        look = localizer.describe(windows[w].query, track.seen[w]).statistics.dense;
      looks.push_back(look);
    }
    return meanOf(looks);
  }

  verdict::Evidence evidenceOfSum(const SequenceAnswer& answer, const Localization& at_best) {
    verdict::Evidence e;
    static_cast<PlaceEvidence&>(e) = tracks.front().sum;
    e.runner_up = e.best_unverified = answer.runner_up;
    e.third = tracks.size() > 2 ? std::max(0.0, tracks[2].sum.score) : 0;
    if (tracks.size() > 1) {
      const PlacePose best = placeNow(tracks[0].seen.back()),
                      next = placeNow(tracks[1].seen.back());
      e.second_best_distance_m = std::hypot(best.x - next.x, best.y - next.y);
      const PoseCheck &here = tracks[0].seen.back(), &there = tracks[1].seen.back();
      e.second_best_distance_m *= localizer.size();  // for words, in lengths of the place
      if (areOnTwoStoreys(here, there))
        e.second_best_distance_m = std::hypot(e.second_best_distance_m, heightBetween(here, there));
    }
    e.windows = answer.windows;
    e.sigma_m = at_best.statistics.sigma_m;
    e.storeys = at_best.statistics.storeys;
    e.other_storey = at_best.statistics.other_storey;
    DenseEvidence& newest = tracks[0].seen.back().evidence.dense = at_best.statistics.dense;
    if (!newest.registered()) return e;
    e.dense = verifyDensely(tracks[0]);
    if (tracks.size() > 1 && newest.converged && e.secondBestIsClose()) {
      e.alternatives = {tracks[1].sum};
      e.alternatives[0].dense = verifyDensely(tracks[1]);
      e.best_unverified = e.third;
    }
    return e;
  }

  /// Windows that count and contradict the best place.
  int windowsAgainst() const {
    const std::vector<bool> counts = counted();
    int against = 0;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const auto share = scoreShare(tracks[0].seen[w].evidence, options.verdict);
      against += counts[w] && share && *share < kContradicts;
    }
    return against;
  }

  /// Verdict on the sum; a best place that the newest window does not agree with is rejected.
  verdict::Verdict verdictOfSum(const SequenceAnswer& answer, const Localization& at_best) {
    verdict::Verdict verdict = localizer.judge(evidenceOfSum(answer, at_best));
    verdict.reason = fmt::format("{} windows together: {}", answer.windows, verdict.reason);
    if (const int against = windowsAgainst(); 2 * against > answer.windows) {
      verdict::refuse(ReasonCode::contradicted,
                      fmt::format("{} of {} windows contradict the place", against, answer.windows),
                      verdict);
      return verdict;
    }
    if (verdict.status != Status::accepted || bestFitsNewest()) return verdict;
    verdict.status = Status::rejected;
    verdict.confidence = std::min(verdict.confidence, answer.alone.confidence);
    verdict.reason =
        fmt::format("{} windows know a place that this one does not agree with; alone: {}",
                    answer.windows, answer.alone.reason);
    return verdict;
  }

  /// Joins the verdicts on the sum and on the newest window alone. An accepted window stays
  /// accepted if the sum has the same place with kConfidenceThreshold or more; it becomes ambiguous
  /// if the sum has another place that it does not accept.
  void decide(const Query& query, SequenceAnswer& answer) {
    constexpr double kConfidenceThreshold = 0.5;
    Localization at_best = atBest(query, answer);
    verdict::Verdict verdict = verdictOfSum(answer, at_best);
    const bool sum_accepts = verdict.status == Status::accepted;
    if (answer.alone.accepted()) {
      const bool same = bestIsThatOf(answer.alone);
      if (same && !sum_accepts && verdict.confidence >= kConfidenceThreshold) return;
      if (same && sum_accepts)
        verdict.confidence = std::max(verdict.confidence, answer.alone.confidence);
      if (!same && !sum_accepts) verdict.status = Status::ambiguous;
      if (!sum_accepts) verdict.reason += "; by itself it would be accepted";
    }
    takeFused(query, std::move(at_best), std::move(verdict), answer);
  }

  /// The answer of the newest window with the hypotheses of the history.
  void takeFused(const Query& query, Localization at_best, verdict::Verdict verdict,
                 SequenceAnswer& answer) const {
    Localization& fix = answer.fix = std::move(at_best);
    const Hypothesis refined = fix.hypotheses.front();
    fix.hypotheses.clear();
    for (std::size_t i = 0;
         i < tracks.size() && i < static_cast<std::size_t>(options.places.hypotheses); ++i) {
      Hypothesis h{tracks[i].seen.back().T_map_query, tracks[i].sum.score, 0, Proposer::search};
      if (i == 0) h = {refined.T_map_query, tracks[i].sum.score, refined.inliers, refined.proposer};
      fix.hypotheses.push_back(h);
    }
    verdict::setVerdict(std::move(verdict), fix);
    refuseOutsidePrior(query, fix);
  }

  /// The history may have led to a place that the prior of this window forbids.
  void refuseOutsidePrior(const Query& query, Localization& fix) const {
    if (!fix.accepted() || localizer.priorAllows(query, fix.T_map_query)) return;
    verdict::refuse(ReasonCode::outside_prior,
                    "the place is outside of the prior; without it: " + fix.reason, fix);
  }

  const Localizer& localizer;
  const Options options;
  std::deque<Window> windows;  ///< oldest first
  std::vector<Track> tracks;   ///< best first
};

Sequence::Sequence(const Localizer& localizer, const Options& options)
    : state_(std::make_unique<State>(localizer, options)) {
  if (!localizer.scoresPoses())
    throw UsageError(
        "method = walks has no evidence that could be summed over windows; use auto or search");
}
Sequence::~Sequence() = default;

SequenceAnswer Sequence::add(const Query& query, std::size_t first, std::size_t last) {
  Stopwatch watch;
  SequenceAnswer answer;
  if (const auto cut = cutByBudget([&] { answer = state_->add(query, first, last); })) {
    state_->forget();
    answer = {};
    answer.alone = answer.fix = *cut;
  }
  const double single = timeOf(answer.alone.timing_ms, "total"),
               together = watch.lap_ms() + totalMs(query.timing_ms);
  Timings& timings = answer.fix.timing_ms;
  timings = answer.alone.timing_ms;
  timings.back().second = together;
  timings.insert(timings.end() - 1, {"sequence", together - single});
  return answer;
}

}  // namespace xview
