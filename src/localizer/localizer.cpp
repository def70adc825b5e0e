// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "base/in_order.h"
#include "base/pose.h"
#include "base/user_text.h"
#include "localizer/level_on_map.h"
#include "localizer/localizer_index.h"
#include "localizer/other_heights.h"
#include "localizer/query_in_map.h"
#include "localizer/storeys_of_map.h"
#include "map/contents.h"
#include "match/consistency.h"
#include "place/raw_recording.h"
#include "place/sound_input.h"
#include "pose/trajectory.h"
#include "search/likelihoods.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/base/semantic_place.h"

namespace xview {
namespace {

constexpr double kFreeSigma_rad = 0.3;  ///< error of an up that only a pose tells
constexpr std::size_t kVerified = 2;    ///< places whose correspondences are looked at, at least
constexpr double kPartnerReach_m = 5;  ///< from a vertex to its partner under a hypothesis, at most
constexpr double kOutOfMapOverlap = 0.1;  ///< map overlap of an out-of-map query, at most
constexpr double kExact_m = 0.05;         ///< depth error below which rays tell free space
constexpr double kAtFeatures_m = 1;  ///< between what is registered and the pose of local features
constexpr double kOnePlace_m =
    4;  ///< travel below which a query has one view-point, in canonical lengths
constexpr double kSureOfPrior =
    0.9999;  ///< confidence from which the outside of a prior is not searched

double travelOf(const Query& query) { return pathLengths(query.poses).back(); }

/// Vertex pairs of a place. Bare graphs pair their vertices by all that is around, which is closer
/// than what walks keep.
const std::vector<Correspondence>& pairsAt(std::size_t place, const Candidates& found) {
  const std::vector<Correspondence>& pairs = found.places[place].pairs;
  return pairs.empty() && place < found.matches.size() ? found.matches[place].poses[0].kept : pairs;
}

template <class Value>
void moveToFront(std::size_t at, std::vector<Value>& values) {
  if (at < values.size()) std::rotate(values.begin(), values.begin() + at, values.begin() + at + 1);
}

/// See Statistics::feature_margin.
double marginOf(const std::vector<match::FeaturePose>& features) {
  constexpr double kByChance = 0.02;
  const double next = features.size() > 1 ? features[1].share : 0;
  return std::max(1.0, features[0].share / std::max(kByChance, next));
}

/// The answer to a query that needs no search.
Localization unfindable(const Query& query, std::string reason) {
  Localization answer;
  answer.vertices = static_cast<int>(query.graph.size());
  answer.reason = std::move(reason);
  answer.T_map_sensor = query.poses.back();
  answer.timing_ms = query.timing_ms;
  answer.timing_ms.emplace_back("total", totalMs(query.timing_ms));
  return answer;
}

/// What a program and a person are told of a query that begins behind a jump of its odometry.
void tellJump(const OdometryJump& jump, std::size_t frames, Localization& answer) {
  const std::string what =
      fmt::format("the scans contradict the odometry, which is off by about {:.1f} m at frame {}",
                  jump.off_m, jump.frame);
  if (answer.accepted()) {
    answer.reason += fmt::format("; {}: the {} frames from there on were used", what, frames);
    return;
  }
  answer.reason = fmt::format("{}; the {} frames from there on: {}", what, frames, answer.reason);
  answer.reason_code = ReasonCode::odometry_jump;
}

}  // namespace

PlaceIndex::PlaceIndex(const map::SemanticMap& given, const Options& all_options,
                       const Method& method_of_options, const map::CommonDetail& detail)
    : options(all_options),
      gravity(gravityOf(given, options.gravity)),
      turned(gravityAlignedMap(given, gravity.alignment)),
      map(turned ? *turned : given),
      shapes_only(knowsShapesOnly(given.labels)),
      verdict_model(verdict::verdictModelOf(options.verdict)),
      prior(parsePrior(options.prior)),
      scales(parseScale("scale", options.scale)),
      walks(map.graph, map.stored_vertices.get(), map.labels, options),
      refinement(map, options),
      method(method_of_options),
      fields(map, options, method.scores_poses, detail),
      proposer(method.make({map, fields, walks, options})),
      feature_index(map, options.threads) {}

Priors PlaceIndex::priorsOf(const Query& given, const Query& upright,
                            const ExpectedPose* expected) const {
  Priors priors{prior};
  if (expected) {
    const Eigen::Isometry3d T = toAligned(given, expected->T_map_query);
    priors.push_back(priorAround({T, expected->radius_m, expected->yaw_rad}, upright));
  }
  return priors;
}

/// The way of a query, in the frames of the caller.
Localization PlaceIndex::localize(const Query& given, const PoseHints& hints) const {
  Stopwatch watch;
  if (const auto reason = whyUnfindable(given, map)) return unfindable(given, *reason);
  const std::optional<Query> centred =
      given.cloud.empty() ? std::nullopt : seenFromItsCentre(given);
  const Query& query = centred ? *centred : given;
  FrameHypothesis frame;
  Localization answer = inAlignedFrames(query, hints, frame);
  leaveAlignedFrames(query, frame, answer);
  if (centred) {
    const Eigen::Vector3d centre = answer.T_map_sensor.translation();
    Eigen::Isometry3d pose = given.poses.back();
    pose.translation() *= answer.scale;
    answer.T_map_sensor = answer.T_map_query * pose;
    if (!answer.trajectory.empty()) answer.trajectory = {answer.T_map_sensor};  // of its one pose
    answer.covariance =
        pose::movedCovariance(answer.covariance, centre, answer.T_map_sensor.translation());
  }
  const double total = watch.lap_ms() + totalMs(given.timing_ms);
  answer.timing_ms.insert(answer.timing_ms.begin(), given.timing_ms.begin(), given.timing_ms.end());
  answer.timing_ms.emplace_back("total", total);
  return answer;
}

/// Where may it be, which vertices correspond there, what is its pose, and is it to be believed?
Localization PlaceIndex::inAlignedFrames(const Query& given, const PoseHints& hints,
                                         FrameHypothesis& frame) const {
  Localization answer;
  const ExpectedPose* const expected = hints.expected;
  const std::vector<match::FeaturePose>& features = hints.features;
  double second_best_score = hints.second_best_score;
  frame = hints.claimed ? FrameHypothesis{alignmentOf(given, *hints.claimed), 1}
                        : chooseFrame(given, expected, second_best_score, answer.timing_ms);
  const AlignedQuery query(given, frame);
  const Priors priors = priorsOf(given, *query, expected);

  Candidates found = proposer->propose(*query, priors, answer.timing_ms);
  found.second_best_score = std::max(found.second_best_score, second_best_score);
  if (expected) keepStoreyOf(toAligned(given, expected->T_map_query), found);
  Eigen::Isometry3d T_by_features;
  if (!features.empty()) {
    T_by_features = features[0].T_map_query * frame.R_up.conjugate();
    addProposed(T_by_features, found);
  }
  if (hints.claimed) putFirst(toAligned(given, *hints.claimed), found);
  matchVertices(*query, found, answer.timing_ms);
  RegisteredPlaces registered = registerPlaces(*query, found, answer);
  if (!hints.claimed) moveLikeliestToFront(found, registered);
  report(found, static_cast<std::size_t>(options.places.hypotheses), answer);
  answer.scale = frame.scale;

  verdict::Evidence evidence = evidenceOf(found, registered);
  evidence.travel_m = map.size * travelOf(*query);  // for words, in lengths of the place
  // What is nearer is what a registration mends.
  if (!features.empty() && !registered.places.empty() &&
      match::isOnePose(T_by_features, registered.places[0].T_map_query * registered.turn,
                       middleOf(*query), kAtFeatures_m))
    evidence.feature_margin = marginOf(features);
  if (!expected) addStoreys(found, map, evidence);
  evidence.second_best_distance_m *= map.size;
  evidence.vertices = answer.vertices =
      static_cast<int>(walks.queryGraph(query->graph).graph.size());
  adoptRefinedPose(registered, answer);
  frame.R_up = registered.turn * frame.R_up;

  setVerdict(judged(evidence), answer);
  if (answer.accepted() && !expected && !evidence.storeys && !found.places.empty()) {
    Stopwatch watch;
    askBudget("other heights");
    const OtherHeight other =
        bestOtherHeight(*query, map, answer.hypotheses[0].T_map_query * registered.turn);
    answer.timing_ms.emplace_back("heights", watch.lap_ms());
    evidence.other_storey = other.fit;
    setVerdict(judged(evidence), answer);
    if (!answer.accepted())
      answer.reason += fmt::format(", {:.1f} m {}", map.size * std::abs(other.above),
                                   other.above > 0 ? "above" : "below");
  }
  if (answer.status == Status::ambiguous) tellStoreys(found, map.size, answer);
  if (answer.accepted() && sayAnything(priors) &&
      !satisfies(priors, query->sensor,
                 answer.hypotheses[0].T_map_query * (registered.turn * query->poses.back())))
    verdict::refuse(ReasonCode::outside_prior,
                    "the refined pose is outside of the prior; without it: " + answer.reason,
                    answer);
  // A pose that is expected comes from a fix; one that a user believes in is to be doubted.
  if (!expected && found.in_field && (prior.near || prior.heading))
    checkOutsidePrior(*found.in_field, evidence, answer);
  return answer;
}

/// X-View's chain at the best few places, not only at the first.
void PlaceIndex::matchVertices(const Query& query, Candidates& found, Timings& timing_ms) const {
  if (!method.matches_vertices) return;
  const std::size_t count = std::min(std::max(kVerified, found.to_register), found.places.size());
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < count; ++i) poses.push_back(found.places[i].T_map_query);
  found.matches =
      walks.matchUnder(poses, walks.queryGraph(query.graph), kPartnerReach_m, timing_ms);
}

/// Levels the query on the ground of the map if that is needed, and registers it at the best place
/// and at those that score about as well.
RegisteredPlaces PlaceIndex::registerPlaces(const Query& query, const Candidates& found,
                                            Localization& answer) const {
  RegisteredPlaces registered;
  if (found.places.empty()) return registered;
  const search::FieldQuery* in_field = fields.isView(query) ? found.in_field.get() : nullptr;
  double up_sigma_rad =
      upIsKnown(query) ? std::hypot(gravity.sigma_rad, query.gravity.sigma_rad) : kFreeSigma_rad;
  answer.gravity = upIsKnown(query) ? GravityUse::aligned : GravityUse::free;
  const auto level = in_field ? levelOnMap(*fields.surfaces(), *in_field, query,
                                           found.places[0].T_map_query, up_sigma_rad, options)
                              : nullptr;
  if (level) {
    registered.turn = level->turn;
    up_sigma_rad = level->up_sigma_rad;
    constexpr double kDegrees = 180 / M_PI;
    answer.gravity = GravityUse::levelled;
    answer.gravity_reason =
        fmt::format("; turned by {:.1f} +- {:.1f} deg onto the ground of the map",
                    Eigen::AngleAxisd(level->turn).angle() * kDegrees, up_sigma_rad * kDegrees);
  }
  const Query& levelled = level ? level->query : query;
  // The runner-up is asked for its agreement from a smaller score on.
  const verdict::Evidence at_best = evidenceOf(found, {});
  const bool ask_runner_up = at_best.secondBestIsClose() && at_best.second_best_distance_m > 0;
  const std::size_t count = std::max<std::size_t>(ask_runner_up ? 2 : 1, found.to_register);
  std::optional<double> self_consistency;
  Stopwatch watch;
  for (std::size_t i = 0; i < count; ++i) {
    askBudget("the registration");
    const Eigen::Isometry3d& T = found.places[i].T_map_query;
    Timings unused;
    RefinedPose place =
        refinement.refine(levelled, level ? level->in_field.get() : in_field,
                          level && i == 0 ? level->T_map_query : T * registered.turn.conjugate(),
                          pairsAt(i, found), up_sigma_rad, i == 0 ? answer.timing_ms : unused);
    setVisibility(query, levelled, in_field ? in_field->visibility(T) : Visibility(),
                  self_consistency, place);
    registered.places.push_back(std::move(place));
    if (i == 0) watch.lap_ms();
  }
  if (count > 1) answer.timing_ms.emplace_back("rival", watch.lap_ms());
  return registered;
}

/// Overlaps of query and map at a place (`seen` in the field) and the free-space violation there.
/// Where the field does not tell, the inlier ratio is a share of `self_consistency`, that of the
/// query with itself, which is measured at the first call.
void PlaceIndex::setVisibility(const Query& query, const Query& levelled, Visibility seen,
                               std::optional<double>& self_consistency, RefinedPose& place) const {
  DenseEvidence& dense = place.dense;
  // What a query does not show may be what its shapes do not tell.
  if (seen.map_overlap && shapes_only) {
    seen.map_overlap = std::max(0.0, *seen.map_overlap);
    seen.miss_ratio = std::min(kConflictThreshold, *seen.miss_ratio);
  }
  dense.aerial = query.bev.aerial || map.bev.aerial;
  const bool is_camera = query.sensor == Sensor::camera;
  dense.indoors = is_camera && surroundingsOf(map.size) == search::Surroundings::rooms;
  dense.narrow = is_camera && !dense.indoors;
  // A query cannot show what stands behind what it shows from one place, and a scanner shows walls
  // that it sees aslant less densely than the ground before them; but rays tell.
  const bool is_exact = query.cloud.typicalSigma() <= kExact_m;
  const double shown = is_exact && !is_camera          ? verdict::kUsualMapOverlap
                       : travelOf(query) < kOnePlace_m ? kOutOfMapOverlap
                                                       : -INFINITY;
  const bool shows_little = !seen.map_overlap || *seen.map_overlap < shown;
  if ((shows_little || is_exact) && dense.converged)
    dense.free_space_violation = refinement.freeSpaceViolation(levelled, place.T_map_query);
  static_cast<Visibility&>(dense) = seen;
  if (seen.map_overlap && !(shows_little && dense.free_space_violation)) return;
  dense.map_overlap = dense.miss_ratio = std::nullopt;
  if (!dense.converged) return;
  if (!self_consistency) self_consistency = refinement.selfConsistency(query);
  dense.self_consistency = self_consistency;
}

/// Takes an acceptance back if a place that the prior forbids explains the query far better: then
/// the prior is wrong. Only acceptances that are not clear by far are looked at.
void PlaceIndex::checkOutsidePrior(const search::FieldQuery& in_field,
                                   const verdict::Evidence& inside, Localization& answer) const {
  if (!answer.accepted() || answer.confidence >= kSureOfPrior) return;
  Stopwatch watch;
  const search::SearchResult anywhere =
      search::search(in_field, {}, options.places, options.threads);
  if (!anywhere.places.empty()) {
    verdict::Evidence outside;
    static_cast<PlaceEvidence&>(outside) = evidenceOf(anywhere.places[0]);
    outside.runner_up = inside.score;
    if (outside.score > inside.score && judged(outside).status == Status::accepted)
      verdict::refuse(
          ReasonCode::outside_prior,
          fmt::format("a place outside of the prior is {:.0f} nats better than the best one "
                      "inside",
                      outside.score - inside.score),
          answer);
  }
  answer.timing_ms.emplace_back("prior", watch.lap_ms());
}

Eigen::Isometry3d scaled(double factor, Eigen::Isometry3d T) {
  scaleLengths(factor, T);
  return T;
}

Localization inMetres(Localization answer, double size) {
  if (size != kTownScale) scaleLengths(size, answer);
  return answer;
}

namespace {

ExpectedPose scaledPose(double factor, const ExpectedPose& pose) {
  return {scaled(factor, pose.T_map_query), factor * pose.radius_m, pose.yaw_rad};
}

}  // namespace

/// The map with no more detail than some queries have.
struct Localizer::CoarseIndices {
  struct Coarse {
    map::SemanticMap map;
    std::unique_ptr<const PlaceIndex> index;
  };
  std::mutex mutex;
  std::map<map::CommonDetail, Coarse> made;
};

/// A map in canonical lengths, and the scale of its own lengths.
struct Localizer::CanonicalMap {
  /// Its lengths are changed where they are.
  CanonicalMap(map::SemanticMap&& given, const Options& options) : size(given.size) {
    requireUse(given, options);
    if (size != kTownScale) scaleLengths(1 / size, given);
    map = std::make_shared<const map::SemanticMap>(std::move(given));
  }
  CanonicalMap(std::shared_ptr<const map::SemanticMap> given, const Options& options) {
    if (!given) throw UsageError("a localizer needs a map");
    if (given->size != kTownScale) {
      *this = CanonicalMap(map::SemanticMap(*given), options);
      return;
    }
    requireUse(*given, options);
    map = std::move(given);
  }

  double size = kTownScale;
  std::shared_ptr<const map::SemanticMap> map;

 private:
  static void requireUse(const map::SemanticMap& map, const Options& options) {
    requireValid(options);
    requirePriorInside(parsePrior(options.prior), map);
  }
};

Localizer::Localizer(map::SemanticMap map, const Options& options, const ClassNames& names)
    : Localizer(CanonicalMap(std::move(map), options), options, names) {}

Localizer::Localizer(std::shared_ptr<const map::SemanticMap> map, const Options& options,
                     const ClassNames& names)
    : Localizer(CanonicalMap(std::move(map), options), options, names) {}

Localizer::Localizer(CanonicalMap map, const Options& options, const ClassNames& names)
    : size_(map.size),
      options_(options),
      names_(names),
      map_(std::move(map.map)),
      index_(std::make_unique<PlaceIndex>(*map_, optionsOfSearch(options, size_, map_->labels),
                                          methodOf(options))),
      coarse_(std::make_unique<CoarseIndices>()) {
  options_.size = sizeText(size_);
}

Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

const map::SemanticMap& Localizer::map() const {
  if (!map_) throw UsageError("a localizer that was moved from has no map; assign another to it");
  return *map_;
}

const PlaceIndex& Localizer::indexFor(const Query& query) const {
  const map::CommonDetail detail = map::commonDetail(query.labels, map().labels);
  if (detail.isAll()) return *index_;
  const std::lock_guard<std::mutex> lock(coarse_->mutex);
  CoarseIndices::Coarse& coarse = coarse_->made[detail];
  if (!coarse.index) {
    coarse.map = map::reduced(*map_, detail, query.labels);
    Options options = index_->options;
    if (detail.shapes && options.places.likelihoods.empty())
      options.places.likelihoods = search::kShapesInLabels;
    coarse.index = std::make_unique<PlaceIndex>(coarse.map, options, index_->method, detail);
  }
  return *coarse.index;
}

bool Localizer::scoresPoses() const { return methodOf(options_).scores_poses; }

Localization Localizer::localize(const Query& query) const { return localizeNear(query, {}); }

Localization Localizer::localize(const Query& query, const ExpectedPose& expected) const {
  requireSound(expected, size_);
  return localizeNear(query, expected);
}

Localization Localizer::localizeNear(const Query& query,
                                     const std::optional<ExpectedPose>& expected,
                                     const Eigen::Isometry3d* claimed,
                                     double second_best_score) const {
  return withinBudget([&] {
    askBudget("the index");
    const PlaceIndex& index = indexFor(query);
    std::optional<ExpectedPose> canonical;
    if (expected) canonical = scaledPose(1 / size_, *expected);
    std::optional<Eigen::Isometry3d> claim;
    if (claimed) claim = scaled(1 / size_, *claimed);
    const PoseHints hints{
        canonical ? &*canonical : nullptr, {}, claim ? &*claim : nullptr, second_best_score};
    Localization answer =
        inMetres(index.localize(*QueryInMap(query, map().labels, size_, names_), hints), size_);
    if (!answer.accepted() && !expected && !claimed && index.method.scores_poses && !index.scales)
      askFeatures(query, index, answer);
    if (answer.accepted() && options_.odometry.check) requireSupport(query, answer);
    if (!query.jumps.empty()) tellJump(query.jumps.back(), query.poses.size(), answer);
    return answer;
  });
}

/// Where the search finds nothing to believe, local features are asked. At the likeliest of their
/// poses the query stands as the map does, whichever way is up in both; it is the answer if it is
/// the best place of the query that stands so.
void Localizer::askFeatures(const Query& query, const PlaceIndex& index,
                            Localization& answer) const {
  constexpr double kAsSaid_rad = 0.2;  ///< how far up may be off where it is said to be z
  Stopwatch watch;
  const auto inMap = [&](const Query& given) { return QueryInMap(given, labels(), size_, names_); };
  const QueryInMap in_map = inMap(query);
  if (!index.feature_index.takes(*in_map)) return;
  const auto lap = [&](const char* stage) {
    const double ms = watch.lap_ms();
    answer.timing_ms.emplace_back(stage, ms);
    valueOf(answer.timing_ms, std::string("total")) += ms;
  };
  const match::FeatureCloud seen = index.feature_index.described(*in_map);
  const std::vector<match::FeaturePose> poses = index.feature_index.propose(seen);
  lap("features");
  if (poses.empty()) return;
  const Eigen::Vector3d up = poses[0].T_map_query.linear().transpose() * Eigen::Vector3d::UnitZ();
  if (options_.gravity == "aligned" && up.z() < std::cos(kAsSaid_rad)) return;
  const Query standing = standingQuery(query, up, options_);
  Localization other = inMetres(index.localize(*inMap(standing), PoseHints{nullptr, poses}), size_);
  lap("standing");
  if (!other.statistics.feature_margin || other.status == Status::rejected) return;
  const auto mirrored = index.feature_index.propose(seen.mirrored());
  lap("mirror");
  const bool is_mirrored = !mirrored.empty() && mirrored[0].share > poses[0].share;
  const bool is_at_a_height =
      !other.statistics.storeys && other.statistics.other_storey.has_value();
  if (!is_mirrored && !other.accepted() && !is_at_a_height) return;
  if (is_mirrored)
    verdict::refuse(ReasonCode::contradicted,
                    "the mirror image of the query fits the map more closely than the query: its "
                    "frame may be left-handed",
                    other);
  // They are pairs of vertices of a graph that the caller does not have.
  other.kept.clear();
  other.putative.clear();
  other.matches = other.inliers = other.hypotheses[0].inliers = 0;
  other.vertices = answer.vertices;
  other.timing_ms = std::move(answer.timing_ms);
  answer = std::move(other);
}

/// Most of a window may be of before the odometry slipped or was stuck, and the answer is the pose
/// of its last frame. An acceptance is taken back if that frame (Place::newest) by itself scores
/// less than a half of what a true pose does where it is put, and more by that at another pose
/// nearby, unless that is what the best of so many wrong poses may score: then it shows too little.
void Localizer::requireSupport(const Query& query, Localization& answer) const {
  constexpr double kReach_m = 1.5, kLeastShare = 0.5, kByChance = 16;
  constexpr double kAround_m = 40, kAround_rad = M_PI, kElsewhere_m = 2;
  if (!query.newest || !scoresPoses() || answer.scale != 1) return;
  const Query& newest = *query.newest;
  const PlaceEvidence here = check(newest, {answer.T_map_query}, kReach_m * size_)[0].evidence;
  const double too_little = kLeastShare * here.expected;
  if (here.score >= too_little || too_little < kByChance) return;
  const Localization nearby =
      localizeNear(newest, ExpectedPose{answer.T_map_query, kAround_m * size_, kAround_rad});
  if (nearby.hypotheses.empty()) return;
  const Eigen::Vector3d sensor = newest.poses.back().translation();
  const double off_m = (nearby.T_map_query * sensor - answer.T_map_query * sensor).norm();
  const double clearly_more = std::max(0.0, here.score) + too_little;
  if (off_m < kElsewhere_m * size_ || nearby.hypotheses[0].score < clearly_more) return;
  verdict::refuse(ReasonCode::odometry_jump,
                  fmt::format("the last frame by itself does not fit where the frames before put "
                              "it, but {:.1f} m from there: the odometry slipped",
                              off_m),
                  answer);
}

void moveLikeliestToFront(Candidates& found, RegisteredPlaces& registered) {
  std::size_t likeliest = 0;
  double most = -INFINITY;
  for (std::size_t i = 0; i < std::min(registered.places.size(), found.to_register); ++i) {
    PlaceEvidence place = evidenceOf(found.places[i]);
    place.dense = registered.places[i].dense;
    const double fit = verdict::denseScore(place, registered.places[0].dense);
    if (fit <= most) continue;
    most = fit;
    likeliest = i;
  }
  moveToFront(likeliest, found.places);
  moveToFront(likeliest, found.matches);
  moveToFront(likeliest, registered.places);
}

namespace {

/// Places of the search that the registration brings together are one place.
bool leadToOnePose(const RefinedPose& a, const RefinedPose& b) {
  constexpr double kOnePose_m = 0.5, kOnePose_rad = 0.05;
  if (!a.dense.converged || !b.dense.converged || a.T_map_sensor.empty() || b.T_map_sensor.empty())
    return false;
  const Eigen::Isometry3d &here = a.T_map_sensor.back(), &there = b.T_map_sensor.back();
  return (here.translation() - there.translation()).norm() < kOnePose_m &&
         rotationBetween(here, there) < kOnePose_rad;
}

}  // namespace

verdict::Evidence evidenceOf(const Candidates& found, const RegisteredPlaces& registered) {
  verdict::Evidence e;
  const std::vector<search::PlaceHypothesis>& places = found.places;
  if (places.empty()) return e;
  const auto registeredAt = [&](std::size_t i) {
    PlaceEvidence place = evidenceOf(places[i]);
    place.dense = registered.places[i].dense;
    return place;
  };
  const auto scoreOf = [&](std::size_t i) { return i < places.size() ? places[i].score() : 0.0; };
  static_cast<PlaceEvidence&>(e) =
      registered.places.empty() ? evidenceOf(places[0]) : registeredAt(0);
  e.runner_up = std::max(found.second_best_score, scoreOf(1));
  e.third = std::max(std::min(found.second_best_score, scoreOf(1)), scoreOf(2));
  for (std::size_t i = 1; i < registered.places.size(); ++i) {
    if (!leadToOnePose(registered.places[0], registered.places[i]))
      e.alternatives.push_back(registeredAt(i));
  }
  e.best_unverified = std::max(found.second_best_score,
                               scoreOf(std::max<std::size_t>(1, registered.places.size())));
  if (!registered.places.empty() && registered.places[0].dense.converged)
    e.sigma_m = verdict::horizontalSigma(registered.places[0].covariance);
  if (places.size() > 1 && scoreOf(1) >= found.second_best_score) {
    const PlacePose &here = places[0].centre, &there = places[1].centre;
    e.second_best_distance_m = std::hypot(here.x - there.x, here.y - there.y);
    if (places[0].storey != places[1].storey)
      e.second_best_distance_m = std::hypot(e.second_best_distance_m, heightBetween(places));
  }
  e.paired = static_cast<int>(pairsAt(0, found).size());
  if (found.matches.empty() || found.matches[0].poses.empty()) return e;
  const match::MatchedPose& chain = found.matches[0].poses[0];
  e.kept = static_cast<int>(chain.kept.size());
  e.with_candidates = chain.with_candidates;
  e.kept_under_null = chain.kept_under_null;
  e.kept_if_true = chain.kept_if_true;
  return e;
}

void adoptRefinedPose(RegisteredPlaces& registered, Localization& answer) {
  if (registered.places.empty()) return;
  for (Hypothesis& h : answer.hypotheses)
    h.T_map_query = h.T_map_query * registered.turn.conjugate();
  RefinedPose& best = registered.places[0];
  answer.hypotheses[0].T_map_query = best.T_map_query;
  answer.covariance = best.covariance;
  answer.trajectory = std::move(best.T_map_sensor);
}

void report(const Candidates& found, std::size_t count, Localization& answer) {
  for (std::size_t i = 0; i < std::min(found.places.size(), count); ++i) {
    const search::PlaceHypothesis& place = found.places[i];
    const bool matched = found.in_field && i < found.matches.size();
    answer.hypotheses.push_back(
        {place.T_map_query, place.score(),
         matched ? static_cast<int>(found.matches[i].poses[0].kept.size()) : place.matched,
         found.by});
  }
  if (found.places.empty()) return;
  answer.kept = pairsAt(0, found);
  if (!found.matches.empty()) {
    answer.putative = found.matches[0].putative;
    if (!found.in_field) answer.consensus_m = found.matches[0].poses[0].consensus_m;
    answer.matches = static_cast<int>(answer.putative.size());
  }
  answer.inliers = answer.hypotheses[0].inliers = static_cast<int>(answer.kept.size());
}

}  // namespace xview
