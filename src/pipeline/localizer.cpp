// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "pipeline/pose_prior.h"
#include "pipeline/vertex_pairs.h"
#include "pipeline/walk_proposer.h"
#include "xview/match/object_places.h"
#include "xview/match/plan_places.h"
#include "xview/pose/refine.h"
#include "xview/types/error.h"
#include "xview/types/pose.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr int kWalkPlaces = 3;           ///< poses that walks may propose in the whole map
constexpr double kPlaceMargin_m = 20;    ///< map vertices this far beyond the query still take part in walks
constexpr double kPairSigma_m = 0.5;     ///< of a pair of vertices, when nothing better is known

std::vector<Eigen::Vector3d> trajectoryOf(const SemanticMap& map) {
  std::vector<Eigen::Vector3d> path;
  for (const Keyframe& k : map.keyframes) path.push_back(k.T_map_sensor.translation());
  return path;
}

void requireKnownLabels(const LabelSet& map, const LabelSet& query) {
  for (const auto& [id, info] : query.classes()) {
    const ClassInfo* known = map.find(id);
    if (known && known->name != info.name) {
      throw Error("label set '" + query.name() + "'", fmt::format("class {} is '{}' here but '{}' in the map (label set '{}')", id, info.name,
                                                                  known->name, map.name()));
    }
  }
}

PlacePose placeOf(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), yawOf(T.linear()), 0};
}

Eigen::Isometry3d poseOf(const PlanHypothesis& h) { return poseFromYaw({h.pose.x, h.pose.y, h.z}, h.pose.yaw); }

/// Query vertices that a wrong pose would bring to agreement by chance: each has some candidates anywhere in the map.
double chanceInliers(const std::vector<Correspondence>& putative, const SemanticGraph& map, double inlier_m) {
  if (map.empty()) return 0;
  Eigen::Vector2d low = map.vertices[0].position.head<2>(), high = low;
  for (const Vertex& v : map.vertices) {
    low = low.cwiseMin(v.position.head<2>());
    high = high.cwiseMax(v.position.head<2>());
  }
  const double area = std::max(1.0, (high - low).prod());
  return static_cast<double>(putative.size()) * M_PI * inlier_m * inlier_m / area;
}

void setVerdict(const Verdict& verdict, Localization& answer) {
  answer.status = verdict.status;
  answer.confidence = verdict.confidence;
  answer.reason = verdict.reason;
}

double radiusOf(const PlanQuery& query) {
  double radius = 0;
  for (const PlanQuery::Sample& s : query.fine) radius = std::max(radius, static_cast<double>(std::hypot(s.x, s.y)));
  return radius;
}

/// Where a pose puts a point of the query. Query frames begin anywhere, so poses of their origins cannot be compared.
PlacePose placeOfPoint(const PlacePose& pose, const Eigen::Vector2d& point) {
  const Eigen::Vector2d p = Eigen::Rotation2Dd(pose.yaw) * point + Eigen::Vector2d(pose.x, pose.y);
  return {p.x(), p.y(), pose.yaw, pose.score};
}

/// Adds a verified pose where its score puts it; a place that is known already keeps the better pose.
void insertPlace(std::vector<PlanHypothesis>& places, std::vector<Proposer>& proposers, const PlanHypothesis& place, Proposer proposer,
                 const Eigen::Vector2d& query_centre) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!samePlace(placeOfPoint(places[i].pose, query_centre), placeOfPoint(place.pose, query_centre))) continue;
    if (place.pose.score <= places[i].pose.score) return;
    places.erase(places.begin() + static_cast<std::ptrdiff_t>(i));
    proposers.erase(proposers.begin() + static_cast<std::ptrdiff_t>(i));
    break;
  }
  const auto at = std::upper_bound(places.begin(), places.end(), place,
                                   [](const PlanHypothesis& a, const PlanHypothesis& b) { return a.pose.score > b.pose.score; });
  proposers.insert(proposers.begin() + (at - places.begin()), proposer);
  places.insert(at, place);
}

void turn(const Eigen::Quaterniond& R, SemanticGraph& graph, LabelledCloud& cloud) {
  for (Vertex& v : graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f turned = R.toRotationMatrix().cast<float>();
  for (pcl::PointXYZL& p : cloud.points) p.getVector3fMap() = turned * p.getVector3fMap();
  cloud.origin = R * cloud.origin;
}

bool isTurned(const Eigen::Quaterniond& R) { return R.angularDistance(Eigen::Quaterniond::Identity()) > 0; }

/// The map in its gravity-aligned frame, if its own is not.
std::optional<SemanticMap> uprightMap(const SemanticMap& map) {
  if (!isTurned(map.plan.upright)) return std::nullopt;
  SemanticMap turned = map;
  turn(map.plan.upright, turned.graph, turned.cloud);
  for (Keyframe& k : turned.keyframes) k.T_map_sensor = map.plan.upright * k.T_map_sensor;
  return turned;
}

Query uprightQuery(const Query& query) {
  Query turned = query;
  turn(query.plan.upright, turned.graph, turned.cloud);
  for (Eigen::Isometry3d& T : turned.poses) T = query.plan.upright * T;
  return turned;
}

}  // namespace

struct Localizer::Index {
  Index(const SemanticMap& semantic_map, const Options& all_options)
      : turned(uprightMap(semantic_map)), map(turned ? *turned : semantic_map), options(all_options), prior(parsePrior(all_options.prior)), walks(map.graph, map.labels, all_options) {
    if (options.method != "walks" && !map.plan.known.empty()) {
      places.emplace(map.plan, trajectoryOf(map), defaultLikelihoods(), options.places, options.threads);
    }
  }

  Localization localize(const Query& query) const;
  void searchPlaces(const Query& query, Localization& answer) const;
  void searchObjects(const Query& query, Localization& answer) const;
  void matchWalks(const Query& query, Localization& answer) const;
  void refinePose(const Query& query, Localization& answer) const;
  void report(const std::vector<PlanHypothesis>& found, const std::vector<Proposer>& proposers, double needed_margin,
              Localization& answer) const;
  PlanQuery recentPart(const Query& query) const;
  bool looksNoWorse(const PlanQuery& recent, const Eigen::Isometry3d& before, const Eigen::Isometry3d& after) const;
  const DistributionMap& distributions() const;
  const ObjectPlaceIndex& objects() const;

  const std::optional<SemanticMap> turned;
  const SemanticMap& map;  ///< gravity-aligned: the caller's, or `turned`
  Options options;
  PlacePrior prior;
  WalkProposer walks;
  std::optional<PlanPlaces> places;
  mutable std::once_flag objects_made, distributions_made;
  mutable std::optional<ObjectPlaceIndex> object_index;
  mutable std::optional<DistributionMap> distribution_map;
};

const DistributionMap& Localizer::Index::distributions() const {
  std::call_once(distributions_made, [&] {
    distribution_map.emplace(map.cloud, map.labels, options.refine.cell_m, options.refine.roughness_m);
  });
  return *distribution_map;
}

const ObjectPlaceIndex& Localizer::Index::objects() const {
  std::call_once(objects_made, [&] { object_index.emplace(map.graph, map.labels, options.objects); });
  return *object_index;
}

/// Place search, then descriptors inside the best place; one verification for the poses of both.
void Localizer::Index::searchPlaces(const Query& query, Localization& answer) const {
  Stopwatch watch;
  const PlanQuery plan_query = makePlanQuery(query.plan);
  std::vector<PlanHypothesis> found = places->search(plan_query, priorOfPoint(prior, query, plan_query.centre), options.threads);
  found.erase(std::remove_if(found.begin(), found.end(), [&](const PlanHypothesis& h) { return !satisfies(prior, query, poseOf(h)); }),
              found.end());
  std::vector<Proposer> proposers(found.size(), Proposer::search);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());

  const WalkGraph walk_query = walks.queryGraph(query.graph);
  WalkGraph part;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  if (!found.empty()) {
    const PlacePose centre = placeOfPoint(found[0].pose, plan_query.centre);
    part = walks.mapAround({centre.x, centre.y}, radiusOf(plan_query) + kPlaceMargin_m);
    if (options.method == "auto") {
      const WalkProposals proposals = walks.proposeIn(part, walk_query);
      for (const WalkProposal& p : proposals.poses) {
        const PlanHypothesis verified = places->verify(plan_query, placeOf(p.T_map_query));
        if (satisfies(prior, query, poseOf(verified))) insertPlace(found, proposers, verified, Proposer::walks, plan_query.centre);
      }
      answer.putative = proposals.putative;
      answer.matches = static_cast<int>(proposals.putative.size());
      answer.timing_ms.emplace_back("descriptors", proposals.descriptors_ms);
      answer.timing_ms.emplace_back("rejection", watch.lap_ms() - proposals.descriptors_ms);
    }
  }
  const bool from_the_air = plan_query.viewpoint == Viewpoint::air;
  report(found, proposers, options.verdict.min_margin * (from_the_air ? options.verdict.aerial_margin_factor : 1), answer);
  if (!found.empty()) {
    answer.kept = pairsUnderPose(walk_query, part, answer.hypotheses[0].T_map_query, options.consensus.inlier_m);
    answer.hypotheses[0].inliers = answer.inliers = static_cast<int>(answer.kept.size());
  }
}

void Localizer::Index::report(const std::vector<PlanHypothesis>& found, const std::vector<Proposer>& proposers, double needed_margin,
                              Localization& answer) const {
  for (std::size_t i = 0; i < found.size(); ++i) {
    answer.hypotheses.push_back({poseOf(found[i]), found[i].pose.score, found[i].objects_matched, proposers[i]});
  }
  PlaceEvidence evidence;
  if (!found.empty()) {
    evidence = {found[0].pose.score, found.size() > 1 ? std::max(0.0, found[1].pose.score) : 0.0, found[0].expected,
                found[0].known_share, static_cast<int>(found.size())};
  }
  setVerdict(judge(evidence, needed_margin, options.verdict), answer);
}

void Localizer::Index::searchObjects(const Query& query, Localization& answer) const {
  Stopwatch watch;
  ObjectSearchRequest request;
  request.threads = options.threads;
  request.focus = query.poses.back().translation();
  request.prior = priorOfPoint(prior, query, request.focus->head<2>());
  const ObjectSearchResult result = objects().search(query.graph, request);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  answer.vertices = result.vertices;
  answer.matches = result.poses;
  const auto count = std::min(result.hypotheses.size(), static_cast<std::size_t>(options.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const ObjectHypothesis& h = result.hypotheses[i];
    answer.hypotheses.push_back({h.T_map_query, h.score, static_cast<int>(h.inliers.size()), Proposer::search});
  }
  PlaceEvidence evidence;
  if (count > 0) {
    const ObjectHypothesis& best = result.hypotheses[0];
    evidence = {best.score, result.wrong.count > 0 ? std::max(0.0, result.wrong.best) : 0.0, best.expected, best.known_share,
                static_cast<int>(result.hypotheses.size())};
    answer.kept = best.inliers;
    answer.inliers = static_cast<int>(best.inliers.size());
  }
  setVerdict(judge(evidence, neededMargin(options.verdict.min_object_margin, result.vertices), options.verdict), answer);
}

/// The paper's localization: descriptors against the whole map.
void Localizer::Index::matchWalks(const Query& query, Localization& answer) const {
  const WalkGraph walk_query = walks.queryGraph(query.graph);
  WalkProposals result = walks.propose(walk_query, kWalkPlaces);
  result.poses.erase(std::remove_if(result.poses.begin(), result.poses.end(),
                                    [&](const WalkProposal& p) { return !satisfies(prior, query, p.T_map_query); }),
                     result.poses.end());
  answer.putative = result.putative;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  answer.matches = static_cast<int>(result.putative.size());
  answer.timing_ms.emplace_back("descriptors", result.descriptors_ms);
  answer.timing_ms.emplace_back("matching", result.matching_ms);
  answer.timing_ms.emplace_back("rejection", result.rejection_ms);
  answer.timing_ms.emplace_back("pose", result.pose_ms);
  ConsensusEvidence evidence;
  evidence.vertices = answer.vertices;
  evidence.chance_inliers = chanceInliers(result.putative, map.graph, options.consensus.inlier_m);
  const Eigen::Vector2d last = query.poses.back().translation().head<2>();
  for (const WalkProposal& p : result.poses) {
    const auto inliers = static_cast<int>(p.inliers.size());
    if (!answer.hypotheses.empty() && evidence.runner_up == 0 &&
        !samePlace(placeOfPoint(placeOf(answer.hypotheses[0].T_map_query), last), placeOfPoint(placeOf(p.T_map_query), last))) {
      evidence.runner_up = inliers;
    }
    answer.hypotheses.push_back({p.T_map_query, static_cast<double>(inliers), inliers, Proposer::walks});
  }
  if (!result.poses.empty()) {
    evidence.inliers = answer.inliers = answer.hypotheses[0].inliers;
    answer.kept = result.poses[0].inliers;
  }
  setVerdict(judge(evidence, options.verdict), answer);
}

/// The clouds see only some classes and take the nearest surface for the right one; what is seen from above must not contradict them.
bool Localizer::Index::looksNoWorse(const PlanQuery& recent, const Eigen::Isometry3d& before, const Eigen::Isometry3d& after) const {
  constexpr double kScoreKept = 0.65;
  if (recent.empty()) return true;
  return places->score(recent, placeOf(after)) >= kScoreKept * places->score(recent, placeOf(before));
}

/// What lies around the last pose: the older part of the window has drifted against it.
PlanQuery Localizer::Index::recentPart(const Query& query) const {
  constexpr float kRecent_m = 20;
  if (!places || query.plan.known.empty()) return {};
  PlanQuery recent = makePlanQuery(query.plan);
  const Eigen::Vector2f sensor = (query.poses.back().translation().head<2>() - recent.centre).cast<float>();
  recent.fine.erase(std::remove_if(recent.fine.begin(), recent.fine.end(),
                                   [&](const PlanQuery::Sample& s) { return (Eigen::Vector2f(s.x, s.y) - sensor).norm() > kRecent_m; }),
                    recent.fine.end());
  return recent;
}

void Localizer::Index::refinePose(const Query& query, Localization& answer) const {
  Hypothesis& best = answer.hypotheses[0];
  const Eigen::Vector3d sensor = query.poses.back().translation();
  answer.covariance = covarianceOfPairs(answer.kept, map.graph, best.T_map_query * sensor, kPairSigma_m);
  if (!options.refine.enabled || query.cloud.empty() || map.cloud.empty()) return;
  Stopwatch watch;
  const PlanQuery recent = recentPart(query);
  if (!recent.empty()) {
    const PlanHypothesis near = places->verify(recent, placeOf(best.T_map_query));
    const Eigen::Isometry3d T = poseOf(near);
    if ((T * sensor - best.T_map_query * sensor).norm() < options.refine.max_shift_m) best.T_map_query = T;
  }
  const Refinement refined = refine(distributions(), query.cloud, query.labels, best.T_map_query, sensor, options.refine);
  if (refined.converged && looksNoWorse(recent, best.T_map_query, refined.T_map_query)) {
    best.T_map_query = refined.T_map_query;
    answer.covariance = refined.covariance;
  }
  answer.timing_ms.emplace_back("refine", watch.lap_ms());
}

/// Query and map gravity-aligned.
Localization Localizer::Index::localize(const Query& query) const {
  Localization answer;
  if (options.method == "walks") matchWalks(query, answer);
  else if (places && !query.plan.known.empty()) searchPlaces(query, answer);
  else searchObjects(query, answer);
  if (!answer.hypotheses.empty()) refinePose(query, answer);
  return answer;
}

Localizer::Localizer(const SemanticMap& map, const Options& options) : index_(std::make_unique<Index>(map, options)) {}
Localizer::~Localizer() = default;

Localization Localizer::localize(const Query& query) const {
  Stopwatch watch;
  requireKnownLabels(index_->map.labels, query.labels);
  Localization answer = index_->localize(isTurned(query.plan.upright) ? uprightQuery(query) : query);
  const Eigen::Isometry3d T_map_upright(index_->map.plan.upright.conjugate());
  for (Hypothesis& h : answer.hypotheses) h.T_map_query = T_map_upright * h.T_map_query * query.plan.upright;
  if (!answer.hypotheses.empty()) {
    answer.T_map_query = answer.hypotheses[0].T_map_query;
    answer.T_map_sensor = answer.T_map_query * query.poses.back();
    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_map_upright.linear();
    answer.covariance = turn * answer.covariance * turn.transpose();
  }
  double total = watch.lap_ms();
  for (const auto& [stage, ms] : query.timing_ms) total += ms;
  answer.timing_ms.insert(answer.timing_ms.begin(), query.timing_ms.begin(), query.timing_ms.end());
  answer.timing_ms.emplace_back("total", total);
  return answer;
}

}  // namespace xview
