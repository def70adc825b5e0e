// SPDX-License-Identifier: BSD-3-Clause
#include "compare/self_similarity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/median.h"
#include "base/parallel.h"
#include "base/pose.h"
#include "base/random.h"
#include "localizer/localizer_index.h"
#include "localizer/pose_refinement.h"
#include "localizer/query_in_map.h"
#include "localizer/storeys_of_map.h"
#include "map/contents.h"
#include "place/gravity.h"
#include "pose/distribution_map.h"
#include "pose/refine.h"
#include "search/distance_field.h"
#include "search/search.h"
#include "verdict/verdict.h"

namespace xview {
namespace {

// Lengths are canonical; every map is brought to canonical scale.
constexpr double kLengths_m[] = {8, 15, 30, 60, 100};
/// Of the stretches that a map remembers. Longer ones cost more and say no more about out-of-map
/// queries.
constexpr double kRememberedLengths_m[] = {15, 30};
constexpr std::size_t kRememberedPlaces = 15;
constexpr double kFullLength = 0.8;      ///< a stretch that is shorter than this share is left out
constexpr double kLeftForOthers = 3;     ///< as is one of a recording shorter than this many of it
constexpr double kSeenAgainShare = 0.6;  ///< of the samples that a second visit sees again
constexpr double kMostPoints = 10000;    ///< of a stretch
constexpr std::size_t kRegisteredPlaces = 3;  ///< wrong places of a stretch, at most
constexpr int kQuickPoints = 1000;            ///< of them that are registered
constexpr double kOdometryError = 0.01;
constexpr double kReach = 0.8;  ///< share of the samples that are nearer to the path
constexpr double kNearest_m = 3, kFarthest_m = 25;  ///< limits of that reach
constexpr std::uint64_t kSeed = 41;

/// A neighbourhood of the map as a query of its own, in a frame of its own.
struct Neighbourhood {
  BevGrid bev;
  SemanticGraph graph;
  LabelledCloud cloud;                   ///< if the best wrong place is asked
  std::vector<Eigen::Isometry3d> poses;  ///< that see it
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
};

/// A position with the noise of a second look.
class VisitNoise {
 public:
  VisitNoise(const Eigen::Isometry3d& T_map_query, double sigma_m, Random& random)
      : T_query_map_(T_map_query.inverse()),
        sigma_m_(sigma_m),
        scale_(1 + kOdometryError * random.uniform(-1, 1)),
        random_(random) {}

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_map) {
    const Eigen::Vector3d error(random_.normal(), random_.normal(), 0);
    return moved(p_map) + sigma_m_ * error;
  }
  /// Of a point that says how far it errs.
  Eigen::Vector3d operator()(const Eigen::Vector3d& p_map, double sigma_m) {
    const Eigen::Vector3d error(random_.normal(), random_.normal(), random_.normal());
    return moved(p_map) + sigma_m * error;
  }

 private:
  Eigen::Vector3d moved(const Eigen::Vector3d& p_map) const {
    return scale_ * (T_query_map_ * p_map);
  }

  Eigen::Isometry3d T_query_map_;
  double sigma_m_, scale_;
  Random& random_;
};

/// Of each key frame, in units of the poses; the way from one recording to the next counts nothing.
std::vector<double> wayOf(const map::SemanticMap& map) {
  std::vector<double> along(map.poses.size(), 0);
  for (std::size_t i = 1; i < along.size(); ++i) {
    const double step = (map.poses[i].translation() - map.poses[i - 1].translation()).norm();
    along[i] = along[i - 1] + (sourceOf(map, i) == sourceOf(map, i - 1) ? step : 0);
  }
  return along;
}

/// The key frames of what was added, from `first` on, at which a stretch is asked: where the way of
/// the whole map passes a multiple of a step, which is a power of two and grows with that way. Of
/// many small additions to a long map only those have such a place that pass one.
std::vector<std::size_t> placesDue(const map::SemanticMap& map, std::size_t first) {
  const std::vector<double> along = wayOf(map);
  const double share = along.back() / (kRememberedPlaces * map.size);
  const double step = map.size * std::max(2.0, std::exp2(std::ceil(std::log2(share))));
  std::vector<std::size_t> due;
  for (std::size_t i = std::max<std::size_t>(first, 1); i < along.size(); ++i) {
    if (std::floor(along[i] / step) > std::floor(along[i - 1] / step)) due.push_back(i);
  }
  return due;
}

/// The map with its field, gravity-aligned, and where its neighbourhoods are.
class SelfSearch {
 public:
  /// `ask_second_best`: what the map and its stretches show of each other at the best wrong place
  /// as well.
  SelfSearch(const map::SemanticMap& map, const Options& options, bool ask_second_best)
      : map_(map),
        options_(options),
        verdict_model_(verdict::verdictModelOf(options.verdict)),
        ask_second_best_(ask_second_best) {
    if (map.poses.size() > 1 && map::hasView(map)) {
      field_ = surfaceFieldOf(map, options);
      along_ = wayOf(map);
      reach_m_ = reachOfPath();
      if (ask_second_best && map::countsOf(map).points > 0)
        distributions_.emplace(distributionsOf(map, options.refine));
    } else {
      field_ = search::makeObjectField(map.graph, map.labels, options.places);
    }
  }

  search::PathNull pathNull() const { return field_->pathNull(); }
  bool hasPath() const { return !along_.empty(); }

  /// Evenly spread key frames, or vertices.
  std::vector<std::size_t> choosePlaces(std::size_t most) const {
    std::vector<std::size_t> chosen;
    if (!hasPath()) {
      const std::size_t step =
          std::max<std::size_t>(1, map_.graph.size() / std::max<std::size_t>(1, most));
      for (std::size_t i = 0; i < map_.graph.size() && chosen.size() < most; i += step)
        chosen.push_back(i);
      return chosen;
    }
    const double step_m = std::max(2.0, along_.back() / static_cast<double>(most));
    for (std::size_t i = 0; i < along_.size() && chosen.size() < most; ++i) {
      if (along_[i] >= step_m * (static_cast<double>(chosen.size()) + 0.5)) chosen.push_back(i);
    }
    return chosen;
  }

  Eigen::Vector3d positionOf(std::size_t place) const {
    return hasPath() ? Eigen::Vector3d(map_.poses[place].translation())
                     : map_.graph.vertices[place].position;
  }

  /// Looks for a neighbourhood. Nothing if the map has no such stretch there.
  std::optional<SelfQuery> ask(std::size_t place, double window_m) const {
    Random random(kSeed ^ static_cast<std::uint64_t>(window_m), place);
    Neighbourhood around;
    around.T_map_query = poseFromYaw(positionOf(place), random.uniform(-M_PI, M_PI));
    if (!(hasPath() ? cutPath(place, window_m, random, around)
                    : cutGraph(place, window_m, random, around)))
      return std::nullopt;
    search::Observation seen;
    seen.bev = hasPath() ? &around.bev : nullptr;
    seen.graph = &around.graph;
    seen.focus = Eigen::Vector3d::Zero();
    const auto query = field_->prepare(seen);
    if (query->empty()) return std::nullopt;
    return judged(*query, around, window_m);
  }

 private:
  /// Length of the way of one recording.
  double pathLengthOf(std::uint32_t source) const {
    double way_m = 0;
    for (std::size_t i = 1; i < along_.size(); ++i) {
      if (sourceOf(map_, i) == source && sourceOf(map_, i - 1) == source)
        way_m += along_[i] - along_[i - 1];
    }
    return way_m;
  }

  /// The columns of a packed view around some key frames, evenly spread.
  BevGrid someColumns(const StoredView& stored) const {
    constexpr std::size_t kMost = 16;
    const auto around = Eigen::Vector2d::Constant(kFarthest_m);
    CellIndex some;
    for (std::size_t i = 0; i < kMost; ++i) {
      const Eigen::Isometry3d& T = map_.poses[(2 * i + 1) * map_.poses.size() / (2 * kMost)];
      const Eigen::Vector2d p =
          T.translation().head<2>() - Eigen::Vector2d(map_.bev.origin_x, map_.bev.origin_y);
      addColumns({p - around, p + around}, some);
    }
    return gathered(stored, some, map_.bev);
  }

  /// Distance from the way within which the map has most of its samples.
  double reachOfPath() const {
    const BevGrid some = map_.stored_view ? someColumns(*map_.stored_view) : BevGrid();
    std::vector<double> distances;
    for (const auto& samples : (map_.stored_view ? some : map_.bev).samples) {
      const std::size_t step = std::max<std::size_t>(1, samples.size() / 200);
      for (std::size_t i = 0; i < samples.size(); i += step) {
        const Eigen::Vector2d p(map_.bev.origin_x + samples[i].x, map_.bev.origin_y + samples[i].y);
        double nearest = 1e18;
        for (const Eigen::Isometry3d& T : map_.poses)
          nearest = std::min(nearest, (T.translation().head<2>() - p).squaredNorm());
        distances.push_back(std::sqrt(nearest));
      }
    }
    if (distances.empty()) return kNearest_m;
    const auto rank = static_cast<std::size_t>(kReach * static_cast<double>(distances.size() - 1));
    return std::clamp(rankedOf(distances, rank), kNearest_m, kFarthest_m);
  }

  /// The stretch of one recording that ends there, or goes on if it began too late.
  bool cutPath(std::size_t place, double window_m, Random& random, Neighbourhood& around) const {
    const auto samePath = [&](std::size_t i) { return sourceOf(map_, i) == sourceOf(map_, place); };
    if (pathLengthOf(sourceOf(map_, place)) < kLeftForOthers * window_m) return false;
    std::size_t first = place, last = place;
    while (first > 0 && samePath(first - 1) && along_[last] - along_[first] < window_m) --first;
    while (last + 1 < along_.size() && samePath(last + 1) &&
           along_[last] - along_[first] < window_m)
      ++last;
    if (along_[last] - along_[first] < kFullLength * window_m) return false;
    std::vector<Eigen::Vector2d> way;
    Eigen::AlignedBox2d box;
    for (std::size_t i = first; i <= last; ++i) {
      const Eigen::Vector2d p = map_.poses[i].translation().head<2>();
      if (way.empty() || (p - way.back()).norm() > reach_m_ / 4) way.push_back(p);
      box.extend(p);
    }
    box.extend(box.min() - Eigen::Vector2d::Constant(reach_m_));
    box.extend(box.max() + Eigen::Vector2d::Constant(reach_m_));
    const auto isSeen = [&](const Eigen::Vector2d& p) {
      return box.contains(p) && std::any_of(way.begin(), way.end(), [&](const auto& w) {
               return (w - p).squaredNorm() < reach_m_ * reach_m_;
             });
    };
    VisitNoise noisy(around.T_map_query, map_.bev.cell_m / 2, random);
    const std::shared_ptr<const BevGrid> view = map::viewWithin(box, map_);
    const Eigen::Vector3d origin(map_.bev.origin_x, map_.bev.origin_y, map_.bev.origin_z);
    around.bev.cell_m = map_.bev.cell_m;
    around.bev.aerial = map_.bev.aerial;
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (const BevSample& s : view->samples[c]) {
        const Eigen::Vector3d p_map = origin + Eigen::Vector3d(s.x, s.y, s.z);
        if (!isSeen(p_map.head<2>()) || random.uniform() > kSeenAgainShare) continue;
        const Eigen::Vector3f p = noisy(p_map).cast<float>();
        around.bev.samples[c].push_back({p.x(), p.y(), p.z()});
      }
    }
    if (ask_second_best_) cutKnown(*view, isSeen, around);
    const auto mayBeSeen = [&](const PlaneCell& column) {
      return box.intersects(StoredCloud::squareOf(column, map_.cloud.origin));
    };
    if (distributions_) cutCloud(first, last, isSeen, mayBeSeen, noisy, random, around);
    return true;
  }

  Eigen::Vector3d inMap(const Point& point) const {
    return map_.cloud.origin + point.getVector3fMap().cast<double>();
  }

  /// The cells that were seen along the stretch.
  template <class IsSeen>
  void cutKnown(const BevGrid& bev, const IsSeen& isSeen, Neighbourhood& around) const {
    const Eigen::Vector3d origin(bev.origin_x, bev.origin_y, bev.origin_z);
    const Eigen::Isometry3d T_query_map = around.T_map_query.inverse();
    for (GroundCell cell : bev.known) {
      const Eigen::Vector3d p_map = origin + Eigen::Vector3d((cell.x + 0.5) * bev.cell_m,
                                                             (cell.y + 0.5) * bev.cell_m, cell.z);
      if (!isSeen(p_map.head<2>())) continue;
      const Eigen::Vector3d p = T_query_map * p_map;
      cell.x = static_cast<std::int32_t>(std::floor(p.x() / bev.cell_m));
      cell.y = static_cast<std::int32_t>(std::floor(p.y() / bev.cell_m));
      cell.z = static_cast<float>(p.z());
      around.bev.known.push_back(cell);
    }
    around.bev.known = onePerCell(std::move(around.bev.known));
  }

  /// Some of the points along key frames, each seen from the nearest of them.
  template <class IsSeen, class MayBeSeen>
  void cutCloud(std::size_t first, std::size_t last, const IsSeen& isSeen,
                const MayBeSeen& mayBeSeen, VisitNoise& noisy, Random& random,
                Neighbourhood& around) const {
    for (std::size_t i = first; i <= last; ++i)
      around.poses.push_back(around.T_map_query.inverse() * map_.poses[i]);
    std::vector<Point> seen;
    map::forPoints(map_, mayBeSeen, [&](const LabelledCloud& points) {
      for (const Point& point : points.points) {
        if (isSeen(inMap(point).template head<2>())) seen.push_back(point);
      }
    });
    const double share = std::min(kSeenAgainShare, kMostPoints / static_cast<double>(seen.size()));
    for (Point point : seen) {
      if (random.uniform() > share) continue;
      const Eigen::Vector3d p = noisy(inMap(point), point.sigma);
      point.getVector3fMap() = p.cast<float>();
      const auto nearest = std::min_element(
          around.poses.begin(), around.poses.end(), [&](const auto& a, const auto& b) {
            return (a.translation() - p).squaredNorm() < (b.translation() - p).squaredNorm();
          });
      point.view = static_cast<std::uint32_t>(nearest - around.poses.begin());
      around.cloud.points.push_back(point);
    }
  }

  /// What speaks for the first of the wrong places, and the margins of the likeliest that was
  /// registered.
  WrongPlace wrongPlaceOf(const search::FieldQuery& query,
                          const std::vector<search::PlaceHypothesis>& wrong,
                          const Neighbourhood& around) const {
    Candidates found;
    found.places = wrong;
    RegisteredPlaces registered;
    for (const search::PlaceHypothesis& h : wrong) {
      if (found.to_register == kRegisteredPlaces) break;
      if (found.to_register > 0 && h.score() < verdict::kAboutAsWell * wrong[0].score()) break;
      registered.places.push_back({h.T_map_query, Matrix6d::Zero(), {}, {}});
      DenseEvidence& dense = registered.places.back().dense;
      static_cast<Visibility&>(dense) = query.visibility(h.T_map_query);
      if (distributions_) registerAt(h.T_map_query, around, dense);
      ++found.to_register;
    }
    WrongPlace result;
    const DenseEvidence& first = registered.places[0].dense;
    if (distributions_) result.above_null = first.inlier_ratio - first.null_inlier_ratio;
    result.miss_ratio = first.miss_ratio;
    moveLikeliestToFront(found, registered);
    const Statistics s = verdict::statisticsOf(evidenceOf(found, registered));
    if (s.dense.registered()) result.dense_margin = s.dense_margin;
    result.likelihood_margin = s.likelihood_margin;
    return result;
  }

  /// Registers the points there as one rigid piece.
  void registerAt(const Eigen::Isometry3d& T_map_query, const Neighbourhood& around,
                  DenseEvidence& dense) const {
    pose::RefineOptions quick = options_.refine;
    quick.model.max_points = kQuickPoints;
    quick.model.start_reach_m = quick.model.drift_share = 0;
    const pose::Refinement fit = pose::refine(*distributions_, {around.cloud, around.poses},
                                              map_.labels, T_map_query, quick);
    dense.of = DenseEvidence::Of::points;
    dense.converged = fit.converged && fit.agreement;
    if (!dense.converged) return;
    dense.inlier_ratio = fit.agreement->found;
    dense.null_inlier_ratio = fit.agreement->null_inlier_ratio;
  }

  bool cutGraph(std::size_t place, double window_m, Random& random, Neighbourhood& around) const {
    const Eigen::Vector3d centre = positionOf(place);
    VisitNoise noisy(around.T_map_query, options_.places.sigma_m / 2, random);
    for (const Vertex& v : map_.graph.vertices) {
      if ((v.position - centre).head<2>().norm() > window_m / 2) continue;
      if (random.uniform() > options_.places.detection) continue;
      Vertex seen = v;
      seen.position = noisy(v.position);
      around.graph.vertices.push_back(seen);
    }
    around.graph.neighbours.resize(around.graph.size());
    return around.graph.size() > 2 && around.graph.size() < map_.graph.size() / 2;
  }

  SelfQuery judged(const search::FieldQuery& query, const Neighbourhood& around,
                   double window_m) const {
    const search::PlaceHypothesis truth = query.verify(around.T_map_query);
    const search::SearchResult found = search::search(query, {}, options_.places, 1);
    SelfQuery result;
    result.window_m = window_m;
    // A copy of the map agrees with it better than any second visit does.
    const bool is_known = truth.expected > 0;
    result.self = is_known ? std::min(truth.score(), truth.expected) : truth.score();
    std::vector<search::PlaceHypothesis> wrong;
    for (const search::PlaceHypothesis& h : found.places) {
      if (!samePlace(h.centre, truth.centre)) wrong.push_back(h);
    }
    // No more than that does another place, be it a copy.
    if (!wrong.empty()) {
      result.wrong = std::min(wrong[0].score(), result.self);
      result.second_best = wrong[0].T_map_query.translation();
      if (ask_second_best_) result.at_second_best = wrongPlaceOf(query, wrong, around);
    }
    if (wrong.size() > 1) result.next_wrong = std::min(wrong[1].score(), result.self);
    verdict::Evidence e;
    e.score = result.self;
    e.runner_up = result.wrong;
    e.third = result.next_wrong;
    e.travel_m = hasPath() ? window_m : 0;
    e.expected = truth.expected;
    e.of_surfaces = truth.of_surfaces;
    e.map_coverage = truth.map_coverage;
    const verdict::Verdict verdict = verdict::judge(e, options_.verdict, verdict_model_);
    result.confidence = verdict.confidence;
    result.sure = verdict.status == Status::accepted;
    return result;
  }

  const map::SemanticMap& map_;
  const Options& options_;
  const verdict::VerdictModel verdict_model_;
  const bool ask_second_best_;
  std::unique_ptr<const search::Field> field_;
  std::optional<pose::DistributionMap> distributions_;  ///< if the best wrong place is asked
  std::vector<double> along_;  ///< way of each key frame; empty for a bare graph
  double reach_m_ = 0;
};

/// The shortest length that is sure and from which on all are.
void conclude(const SelfQuery* first, const SelfQuery* last, SelfSimilarity::Place& place) {
  for (const SelfQuery* q = last; q != first;) {
    --q;
    if (!q->sure) {
      place.second_best = q->second_best;
      return;
    }
    place.min_query_length_m = q->window_m;
  }
}

/// Of the storeys of an upright map the one with most key frames; nothing if it is one plane.
std::optional<StoreyOfMap> mainStorey(const map::SemanticMap& upright) {
  std::optional<StoreyOfMap> main;
  for (StoreyOfMap& storey : storeysOf(upright)) {
    if (!main || storey.map.poses.size() > main->map.poses.size()) main = std::move(storey);
  }
  return main;
}

/// A map upright and at canonical scale; of a building one of its storeys.
struct AlignedMap {
  AlignedMap(const map::SemanticMap& given, const Options& in_metres)
      : options(optionsOfSearch(in_metres, given.size, given.labels)),
        scaled(given, 1 / given.size),
        gravity(gravityOf(*scaled, options.gravity)),
        turned(gravityAlignedMap(*scaled, gravity.alignment)),
        storey(mainStorey(turned ? *turned : *scaled)),
        map(storey   ? storey->map
            : turned ? *turned
                     : *scaled) {}

  const Options options;
  const Scaled<map::SemanticMap> scaled;
  const Gravity gravity;
  const std::optional<map::SemanticMap> turned;
  const std::optional<StoreyOfMap> storey;
  const map::SemanticMap& map;
};

/// By place, then length; none where the map has no such stretch.
template <std::size_t kCount>
std::vector<std::optional<SelfQuery>> askAll(const SelfSearch& search,
                                             const std::vector<std::size_t>& places,
                                             const double (&lengths_m)[kCount], int threads) {
  std::vector<std::optional<SelfQuery>> asked(places.size() * kCount);
  parallelFor(asked.size(), threads, [&](std::size_t i) {
    asked[i] = search.ask(places[i / kCount], lengths_m[i % kCount]);
  });
  return asked;
}

}  // namespace

void measureNullHypothesis(map::SemanticMap& given, const Options& in_metres,
                           std::size_t first_pose) {
  if (first_pose == 0) {
    given.wrong_places.clear();
    given.own_stretches.clear();
    given.null = {};
  }
  const bool may_have_floors = given.size < kTownScale;
  if ((given.poses.size() < 2 && !may_have_floors) || !map::hasView(given)) return;
  if (first_pose > 0 && may_have_floors && !(wayOf(given).back() > 0))  // clouds, of floors perhaps
    return measureNullHypothesis(given, in_metres);
  std::vector<std::size_t> places;
  if (first_pose > 0) {
    places = placesDue(given, first_pose);
    if (places.empty()) {  // so much longer a path changes no share of distances
      if (given.null.poses > 0) given.null.view = map::fingerprintOfView(given);
      return;
    }
  }
  if (given.size == kTownScale && !given.stored_view && !map::hasOverview(given))
    given.overview = search::overviewOfLarge(given.bev);
  const AlignedMap town(given, in_metres);
  if (town.map.poses.size() < 2) return;
  if (town.storey && first_pose > 0) return measureNullHypothesis(given, in_metres);
  const SelfSearch search(town.map, town.options, true);
  if (first_pose == 0) places = search.choosePlaces(kRememberedPlaces);
  if (!town.storey) given.null = search.pathNull();
  for (const auto& q : askAll(search, places, kRememberedLengths_m, town.options.threads)) {
    if (q) given.own_stretches.push_back({q->window_m * given.size, q->confidence});
    if (q && q->second_best) given.wrong_places.push_back(q->at_second_best);
  }
}

SelfSimilarity measureSelfSimilarity(const map::SemanticMap& given, const Options& in_metres,
                                     std::size_t most_places) {
  const AlignedMap town(given, in_metres);
  const SelfSearch search(town.map, town.options, false);
  const std::vector<std::size_t> chosen = search.choosePlaces(most_places);
  constexpr std::size_t kCount = std::size(kLengths_m);
  std::vector<std::optional<SelfQuery>> asked =
      askAll(search, chosen, kLengths_m, town.options.threads);

  SelfSimilarity result;
  const double size = given.size;
  const Eigen::Quaterniond back = town.gravity.alignment.conjugate();
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    SelfSimilarity::Place place;
    if (!town.storey && search.hasPath())
      place.key_frame = chosen[i];
    else if (town.storey && !town.storey->key_frames.empty())
      place.key_frame = town.storey->key_frames[chosen[i]];
    place.position = size * (back * search.positionOf(chosen[i]));
    std::vector<SelfQuery> here;
    for (std::size_t k = 0; k < kCount; ++k) {
      if (std::optional<SelfQuery>& query = asked[i * kCount + k]) {
        query->place = result.places.size();
        query->window_m *= size;
        if (query->second_best) query->second_best = size * (back * *query->second_best);
        here.push_back(*query);
      }
    }
    if (here.empty()) continue;
    conclude(here.data(), here.data() + here.size(), place);
    result.places.push_back(place);
    result.queries.insert(result.queries.end(), here.begin(), here.end());
  }
  for (const double length_m : kLengths_m) result.lengths_m.push_back(size * length_m);
  return result;
}

std::vector<OwnAcceptance> ownAcceptance(const map::SemanticMap& map) {
  std::map<double, OwnAcceptance> by_length;
  for (const map::OwnStretch& stretch : map.own_stretches) {
    OwnAcceptance& all = by_length[stretch.window_m];
    all.window_m = stretch.window_m;
    ++all.stretches;
    for (std::size_t i = 0; i < all.accepted.size(); ++i)
      all.accepted[i] += stretch.confidence >= 1 - OwnAcceptance::kRisks[i];
  }
  std::vector<OwnAcceptance> result;
  for (const auto& [length, acceptance] : by_length) result.push_back(acceptance);
  return result;
}

std::vector<WrongScores> wrongScores(const SelfSimilarity& self_similarity) {
  std::vector<WrongScores> all;
  for (const double length_m : self_similarity.lengths_m) {
    std::vector<double> leads, shares;
    for (const SelfQuery& q : self_similarity.queries) {
      if (q.window_m != length_m) continue;
      const double best = std::max(1.0, q.wrong), next = std::max(1.0, q.next_wrong);
      leads.push_back((best - next) * std::log(best / next));
      shares.push_back(q.wrong / std::max(1.0, q.self));
    }
    if (leads.empty()) continue;
    std::sort(leads.begin(), leads.end());
    std::sort(shares.begin(), shares.end());
    WrongScores scores;
    scores.window_m = length_m;
    scores.queries = leads.size();
    for (std::size_t k = 0; k < WrongScores::kQuantiles.size(); ++k) {
      const auto at = static_cast<std::size_t>(WrongScores::kQuantiles[k] *
                                               static_cast<double>(leads.size() - 1));
      scores.likelihood_margin[k] = leads[at];
      scores.share[k] = shares[at];
    }
    all.push_back(scores);
  }
  return all;
}

bool WrongPlaceMargins::areOfCopies() const {
  constexpr double kUsualDense = 6.5, kUsualLikelihood = 55;  // of 80 usual maps none has more
  return dense > kUsualDense || likelihood > kUsualLikelihood;
}

std::optional<WrongPlaceMargins> wrongPlaceMargins(const map::SemanticMap& map) {
  constexpr std::ptrdiff_t kLargest = 4;
  const auto largest = [&](std::optional<double> WrongPlace::*margin) -> std::optional<double> {
    std::vector<double> margins;
    for (const WrongPlace& place : map.wrong_places) {
      if (place.*margin) margins.push_back(*(place.*margin));
    }
    if (margins.size() <= kLargest) return std::nullopt;
    std::sort(margins.rbegin(), margins.rend());
    return std::accumulate(margins.begin() + 1, margins.begin() + 1 + kLargest, 0.0) / kLargest;
  };
  const auto dense = largest(&WrongPlace::dense_margin),
             likelihood = largest(&WrongPlace::likelihood_margin);
  if (!likelihood) return std::nullopt;
  return WrongPlaceMargins{dense.value_or(0), *likelihood};
}

}  // namespace xview
