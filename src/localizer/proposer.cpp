// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/proposer.h"

#include <algorithm>

#include "base/pose.h"
#include "localizer/level_on_map.h"
#include "localizer/query_in_map.h"
#include "localizer/storeys_of_map.h"
#include "map/contents.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr Method kMethods[] = {{"auto", true, true, makeSearchProposer},
                               {"search", true, false, makeSearchProposer},
                               {"walks", false, false, makeWalkProposer}};

constexpr std::size_t kMostRegistered = 5;  ///< places whose points are registered
constexpr double kEnoughMapOverlap = 0.5;   ///< of the best place: that of others is not computed
constexpr std::size_t kMostAsked = 15;      ///< places whose map overlap is computed otherwise
constexpr double kWorthAsking = 0.4;        ///< least score of such a place, over the best one
constexpr int kWalkPlaces = 3;              ///< poses that walks may propose in the whole map
/// Log-likelihood ratio of a vertex that agrees with a pose of walks, and the number of vertices
/// that agree with a wrong one: a row of houses fits another row, so they come in clusters and grow
/// with the query.
constexpr double kNatsOfInlier = 7, kWrongInliers = 2.5, kWrongInlierShare = 0.09,
                 kMostWrongInliers = 12;

/// The score counts what the query shows of the map, not what it lacks: a wrong place that the map
/// knows well may have a larger score than the right one. If the map overlap of the best place is
/// small, the place with the highest dense score is registered as well.
void proposeByMapOverlap(Candidates& found) {
  const auto fitOf = [&](const search::PlaceHypothesis& place) {
    PlaceEvidence evidence = evidenceOf(place);
    static_cast<Visibility&>(evidence.dense) = found.in_field->visibility(place.T_map_query);
    return std::make_pair(evidence.dense.map_overlap,
                          verdict::denseScore(evidence, evidence.dense));
  };
  const auto [shown, fit_of_best] = fitOf(found.places[0]);
  if (!shown || *shown >= kEnoughMapOverlap) return;
  double most = fit_of_best;
  std::size_t likeliest = 0;
  for (std::size_t i = found.to_register; i < std::min(kMostAsked, found.places.size()); ++i) {
    if (found.places[i].score() < kWorthAsking * found.places[0].score()) break;
    const double fit = fitOf(found.places[i]).second;
    if (fit <= most) continue;
    most = fit;
    likeliest = i;
  }
  if (likeliest == 0) return;
  found.places[likeliest] = found.in_field->verify(found.places[likeliest].T_map_query);
  std::rotate(found.places.begin() + found.to_register, found.places.begin() + likeliest,
              found.places.begin() + likeliest + 1);
  ++found.to_register;
}

auto sameAs(const search::PlaceHypothesis& place) {
  return [&place](const search::PlaceHypothesis& other) {
    return (other.T_map_query.translation() - place.T_map_query.translation()).norm() <
               kSamePlace_m &&
           rotationBetween(other.T_map_query, place.T_map_query) < kSamePlace_rad;
  };
}

class SearchProposer final : public PlaceProposer {
 public:
  explicit SearchProposer(const ProposerInputs& inputs)
      : fields_(inputs.fields), options_(inputs.options) {}

  Candidates propose(const Query& query, const Priors& priors, Timings& timing_ms) const override {
    askBudget("the search");
    Stopwatch watch;
    Candidates found;
    found.in_field = fields_.prepare(query);
    search::SearchResult result = search::search(*found.in_field, ofQueryFrame(priors, query),
                                                 options_.places, options_.threads);
    found.places = std::move(result.places);
    found.second_best_score = result.outside;
    found.to_register = countClose(found.places);
    if (fields_.isView(query) && !found.places.empty()) proposeByMapOverlap(found);
    timing_ms.emplace_back("matching", watch.lap_ms());
    return found;
  }

 private:
  const MapFields& fields_;
  const Options& options_;
};

/// The score of a pose is proportional to the number of vertices that agree with it.
class WalkProposer final : public PlaceProposer {
 public:
  explicit WalkProposer(const ProposerInputs& inputs) : walks_(inputs.walks) {}

  Candidates propose(const Query& query, const Priors& priors, Timings& timing_ms) const override {
    Candidates found;
    found.by = Proposer::walks;
    const match::WalkGraph graph = walks_.queryGraph(query.graph);
    match::WalkMatches matches =
        walks_.matchEverywhere(graph, kWalkPlaces, query.gravity.known, timing_ms);
    found.second_best_score =
        kNatsOfInlier *
        std::min(kMostWrongInliers,
                 kWrongInliers + kWrongInlierShare * static_cast<double>(graph.graph.size()));
    for (match::MatchedPose& pose : matches.poses) {
      if (!satisfies(priors, query.sensor, pose.T_map_query * query.poses.back())) continue;
      search::PlaceHypothesis place;
      place.T_map_query = pose.T_map_query;
      place.centre.score = kNatsOfInlier * static_cast<double>(pose.kept.size());
      place.matched = static_cast<int>(pose.kept.size());
      place.map_coverage = 1;
      place.pairs = pose.kept;
      found.places.push_back(std::move(place));
      if (found.matches.empty()) found.matches.push_back({matches.putative, {std::move(pose)}});
    }
    found.to_register = countClose(found.places);
    return found;
  }

 private:
  const match::WalkMatcher& walks_;
};

}  // namespace

const Method& methodOf(const Options& options) {
  for (const Method& method : kMethods) {
    if (options.method == method.name) return method;
  }
  throw UsageError("there is no method " + options.method);
}

std::unique_ptr<const PlaceProposer> makeSearchProposer(const ProposerInputs& inputs) {
  return std::make_unique<const SearchProposer>(inputs);
}

std::unique_ptr<const PlaceProposer> makeWalkProposer(const ProposerInputs& inputs) {
  return std::make_unique<const WalkProposer>(inputs);
}

std::size_t countClose(const std::vector<search::PlaceHypothesis>& places) {
  std::size_t count = 0;
  while (count < std::min(kMostRegistered, places.size()) &&
         places[count].score() >= verdict::kAboutAsWell * places[0].score())
    ++count;
  return count;
}

void addProposed(const Eigen::Isometry3d& T_map_query, Candidates& found) {
  if (!found.in_field) return;
  const search::PlaceHypothesis place = found.in_field->verify(T_map_query);
  std::vector<search::PlaceHypothesis>& places = found.places;
  verdict::Evidence alone;  // of the search
  alone.score = places.empty() ? 0 : places[0].score();
  alone.runner_up = places.size() > 1 ? places[1].score() : 0;
  if (found.to_register == 1 && places.size() > 1 && alone.secondBestIsClose())
    found.to_register = 2;
  auto at = std::find_if(places.begin(), places.end(), sameAs(place));
  if (at == places.end()) {
    const auto is_worse = [&](const search::PlaceHypothesis& other) {
      return other.score() < place.score();
    };
    at = places.insert(std::find_if(places.begin(), places.end(), is_worse), place);
  }
  const auto first_other = places.begin() + static_cast<std::ptrdiff_t>(found.to_register);
  if (at < first_other) return;
  if (at != first_other)  // which is behind it now, and still is what others score
    found.second_best_score = std::max(found.second_best_score, first_other->score());
  std::rotate(first_other, at, at + 1);
  ++found.to_register;
}

void putFirst(const Eigen::Isometry3d& T_map_query, Candidates& found) {
  const search::PlaceHypothesis place = found.in_field->verify(T_map_query);
  std::vector<search::PlaceHypothesis>& places = found.places;
  places.erase(std::remove_if(places.begin(), places.end(), sameAs(place)), places.end());
  found.to_register = std::min(kMostRegistered, 1 + countClose(places));
  places.insert(places.begin(), place);
}

PlaceEvidence evidenceOf(const search::PlaceHypothesis& place) {
  return {place.score(),      place.expected,
          place.map_coverage, {place.obstacles.score, place.obstacles.expected},
          place.of_surfaces,  {}};
}

MapFields::MapFields(const map::SemanticMap& map, const Options& options, bool with_views,
                     const map::CommonDetail& detail)
    : map_(map), options_(options) {
  if (!with_views || !map::hasView(map)) return;
  surfaces_ = surfaceFieldOf(map, options, detail);
}

std::unique_ptr<const search::FieldQuery> MapFields::prepare(const Query& query) const {
  if (isView(query)) return surfaces_->prepare(observationOf(query));
  std::call_once(objects_made_, [&] {
    objects_ = search::makeObjectField(map::allVertices(map_), map_.labels, options_.places);
  });
  return objects_->prepare(observationOf(query));
}

}  // namespace xview
