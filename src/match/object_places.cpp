// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/object_places.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "object_heights.h"
#include "object_rasters.h"
#include "object_verifier.h"
#include "xview/types/parallel.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr std::size_t kSmallMap = 1000;  // vertices; the fine raster is searched directly
constexpr double kCellsPerRoot =
    37;  // cells kept of the first look: 3700 for 10,000 vertices, 37,000 for a million
constexpr std::size_t kCellsPerPose = 20;  // kept of small maps: many are neighbours
constexpr double kCoarseYawStep = 0.16, kFineYawStep = 0.105;  // [rad]
constexpr double kCentreMargin = 15;   // [m] beyond the gap around the query's own centre
constexpr double kLargestWhole = 400;  // [m] radius; larger queries are searched for in parts
constexpr std::size_t kParts = 3, kGrown = 3;  // dense parts; places of each that are tried on all
constexpr double kGrowth = 2;                  // of the radius of a part, again and again
// Scales of the standard deviations for the poses that are told: vertices that are less noisy than
// assumed need not be smoothed as much.
constexpr double kWidestAtLast = 1.2, kNarrowestAtLast = 0.3, kDeviationsAtLast = 1.3;
constexpr double kSameMetres = 1, kSameRadians = 0.05;  // refined poses this close are one

struct Scored {
  CentrePose pose;
  double score = 0;
};

/// Best first; equal scores in the order of the plane.
bool isBetter(const Scored& a, const Scored& b) {
  return std::make_tuple(-a.score, a.pose.y, a.pose.x, a.pose.yaw) <
         std::make_tuple(-b.score, b.pose.y, b.pose.x, b.pose.yaw);
}

bool areSame(const CentrePose& a, const CentrePose& b) {
  const double dx = a.x - b.x, dy = a.y - b.y;
  return dx * dx + dy * dy < kSameMetres * kSameMetres &&
         std::abs(angleDifference(a.yaw, b.yaw)) < kSameRadians;
}

/// Sorts and keeps the best of poses that ran together, at most `keep`.
void keepDistinct(std::vector<Scored>& poses, std::size_t keep) {
  std::sort(poses.begin(), poses.end(), isBetter);
  std::vector<Scored> kept;
  for (const Scored& s : poses) {
    if (kept.size() >= keep) break;
    if (std::none_of(kept.begin(), kept.end(),
                     [&](const Scored& k) { return areSame(k.pose, s.pose); }))
      kept.push_back(s);
  }
  poses = std::move(kept);
}

/// A rough look: one step, tolerant score.
Scored lookedAt(ObjectVerifier& verifier, const CentrePose& pose) {
  verifier.moveTo(pose);
  const CentrePose better = verifier.improved(pose, 1.8);
  const double seen = verifier.score(better, 1.3);
  return {better, seen - verifier.missedObjects(better) - verifier.heightCost()};
}

Scored refined(ObjectVerifier& verifier, CentrePose pose) {
  verifier.moveTo(pose);
  for (const double widen : {1.8, 1.4, 1.2, 1.0, 1.0}) pose = verifier.improved(pose, widen);
  const double seen = verifier.score(pose, 1);
  return {pose, seen - verifier.missedObjects(pose) - verifier.heightCost()};
}

/// Calls work(verifier, i) for all i, each thread with a verifier of its own.
template <class Work>
void verifyAll(std::size_t count, int threads, const ObjectMap& map, const ObjectQuery& query,
               const ObjectPlaceOptions& options, const Work& work) {
  constexpr std::size_t kChunk = 16;
  parallelFor((count + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    ObjectVerifier verifier(map, query, options);
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i)
      work(verifier, i);
  });
}

/// The rotation that tilts an upright query by a slope of its heights.
Eigen::AngleAxisd tilted(const Eigen::Vector2d& slope) {
  const double rise = slope.norm();
  if (rise < 1e-9) return Eigen::AngleAxisd(0, Eigen::Vector3d::UnitX());
  return Eigen::AngleAxisd(std::atan(rise), Eigen::Vector3d(slope.y(), -slope.x(), 0) / rise);
}

/// Pairs that are more likely than not, each vertex in one of them at most, in the order of the
/// query.
std::vector<Correspondence> inliersOf(const ObjectVerifier& verifier, const ObjectQuery& query) {
  std::vector<Correspondence> inliers;
  for (std::size_t i = 0; i < query.items().size(); ++i) {
    const Association& association = verifier.associations()[i];
    if (association.chance() <= 0.5f) continue;
    inliers.push_back({query.items()[i].vertex, verifier.mapPoint(association.local).vertex,
                       association.chance()});
  }
  std::sort(inliers.begin(), inliers.end(), [](const Correspondence& a, const Correspondence& b) {
    return std::make_tuple(a.map, -a.similarity, a.query) <
           std::make_tuple(b.map, -b.similarity, b.query);
  });
  const auto last =
      std::unique(inliers.begin(), inliers.end(),
                  [](const Correspondence& a, const Correspondence& b) { return a.map == b.map; });
  inliers.erase(last, inliers.end());
  std::sort(inliers.begin(), inliers.end(),
            [](const Correspondence& a, const Correspondence& b) { return a.query < b.query; });
  return inliers;
}

WrongPoses describeWrong(const std::vector<ObjectHypothesis>& best, const std::vector<Scored>& all,
                         const Eigen::Vector3d& origin) {
  WrongPoses wrong;
  if (best.empty()) return wrong;
  double sum = 0, squares = 0;
  for (const Scored& s : all) {
    if (samePlace({s.pose.x + origin.x(), s.pose.y + origin.y(), s.pose.yaw, 0},
                  best.front().centre))
      continue;
    wrong.best = wrong.count == 0 ? s.score : std::max(wrong.best, s.score);
    sum += s.score;
    squares += s.score * s.score;
    ++wrong.count;
  }
  if (wrong.count == 0) return wrong;
  wrong.mean = sum / wrong.count;
  wrong.deviation = std::sqrt(std::max(0.0, squares / wrong.count - wrong.mean * wrong.mean));
  return wrong;
}

}  // namespace

struct ObjectPlaceIndex::Index {
  ObjectPlaceOptions options;
  ObjectMap map;
  LikelihoodRaster fine;
  std::optional<LikelihoodRaster> coarse;

  Index(const SemanticGraph& graph, const LabelSet& labels, const ObjectPlaceOptions& o)
      : options(o), map(graph, labels, o), fine(rasterizeObjects(map, o, o.fine_cell_m)) {
    if (map.points().size() > kSmallMap) coarse = rasterizeObjects(map, o, o.coarse_cell_m);
  }

  ObjectSearchResult searchWhole(const ObjectQuery& query,
                                 const ObjectSearchRequest& request) const;
  ObjectSearchResult searchInParts(const SemanticGraph& graph, const QueryPart& whole,
                                   const ObjectSearchRequest& request) const;
  ObjectSearchResult answer(const ObjectQuery& query, std::vector<Scored> poses,
                            const ObjectSearchRequest& request) const;
  CentrePose grown(const SemanticGraph& graph, QueryPart part, const ObjectQuery& whole,
                   const Eigen::Isometry3d& T_map_part) const;
  std::size_t posesKept() const;
  std::vector<Scored> propose(const ObjectQuery& query, const ObjectSearchRequest& request) const;
  ObjectHypothesis describe(ObjectVerifier& verifier, const ObjectQuery& query,
                            const Scored& scored, const ObjectSearchRequest& request) const;
  PlacePrior centrePrior(const ObjectQuery& query, const ObjectSearchRequest& request) const;
  bool agreesWithPrior(const ObjectQuery& query, const ObjectSearchRequest& request,
                       const CentrePose& pose) const;
};

namespace {

Eigen::Vector3d priorPoint(const ObjectSearchRequest& request) {
  return request.focus ? *request.focus : Eigen::Vector3d::Zero();
}

}  // namespace

/// The circle for the query centre: wider by the lever from the point that the prior speaks of.
PlacePrior ObjectPlaceIndex::Index::centrePrior(const ObjectQuery& query,
                                                const ObjectSearchRequest& request) const {
  PlacePrior prior = request.prior;
  if (prior.near) {
    prior.near->x -= map.origin().x();
    prior.near->y -= map.origin().y();
    prior.near->radius +=
        (query.centre() - priorPoint(request)).head<2>().norm() + options.fine_cell_m;
  }
  if (prior.heading) prior.heading->tolerance += kFineYawStep / 2;
  return prior;
}

bool ObjectPlaceIndex::Index::agreesWithPrior(const ObjectQuery& query,
                                              const ObjectSearchRequest& request,
                                              const CentrePose& pose) const {
  const auto& [near, heading] = request.prior;
  if (heading && std::abs(angleDifference(pose.yaw, heading->yaw)) > heading->tolerance + 1e-9)
    return false;
  if (!near) return true;
  const Eigen::Vector2d lever = (priorPoint(request) - query.centre()).head<2>();
  const Eigen::Vector2d p = Eigen::Vector2d(pose.x, pose.y) + map.origin().head<2>() +
                            Eigen::Rotation2Dd(pose.yaw) * lever;
  return (p - Eigen::Vector2d(near->x, near->y)).norm() <= near->radius + 1e-9;
}

/// The more places there are, the more of them look as good as the right one at first.
std::size_t ObjectPlaceIndex::Index::posesKept() const {
  if (options.keep_poses > 0) return static_cast<std::size_t>(options.keep_poses);
  const double vertices = static_cast<double>(map.points().size());
  return static_cast<std::size_t>(std::clamp(150 * std::pow(vertices / 1e4, 0.3), 60.0, 600.0));
}

std::vector<Scored> ObjectPlaceIndex::Index::propose(const ObjectQuery& query,
                                                     const ObjectSearchRequest& request) const {
  RasterSearchOptions search;
  search.threads = request.threads;
  search.margin_m = query.emptyRadius() + kCentreMargin;
  search.keep_poses = posesKept();
  search.centre_prior = centrePrior(query, request);
  const auto wanted_cells = static_cast<std::size_t>(options.keep_cells);
  const std::vector<RasterSample> samples = query.samples(map, options.fine_cell_m);
  std::vector<PlacePose> places;
  if (coarse) {
    const auto by_size = static_cast<std::size_t>(kCellsPerRoot * std::sqrt(map.points().size()));
    search.max_yaw_step_rad = kCoarseYawStep;
    search.keep_cells = wanted_cells ? wanted_cells : by_size;
    places = searchRaster(*coarse, query.samples(map, options.coarse_cell_m),
                          {fine, samples, kFineYawStep}, search);
  } else {
    search.max_yaw_step_rad = kFineYawStep;
    search.keep_cells = wanted_cells ? wanted_cells : kCellsPerPose * search.keep_poses;
    places = searchRaster(fine, samples, search);
  }
  std::vector<Scored> poses;
  for (const PlacePose& place : places)
    poses.push_back({{place.x, place.y, place.yaw}, place.score});
  return poses;
}

ObjectHypothesis ObjectPlaceIndex::Index::describe(ObjectVerifier& verifier,
                                                   const ObjectQuery& query, const Scored& scored,
                                                   const ObjectSearchRequest& request) const {
  CentrePose pose = scored.pose;
  verifier.moveTo(pose);
  ObjectHypothesis hypothesis;
  hypothesis.score = scored.score;
  hypothesis.expected = verifier.expectedScore(pose);
  hypothesis.known_share = verifier.knownShare();
  std::optional<Eigen::Vector2d> focus;
  if (request.focus) focus = (*request.focus - query.centre()).head<2>();
  double widen = kWidestAtLast;
  for (int k = 0; k < 4; ++k) {
    pose = verifier.improved(pose, widen, focus);
    widen = std::clamp(kDeviationsAtLast * verifier.scatter(), kNarrowestAtLast, kWidestAtLast);
  }
  verifier.score(pose, 1);
  hypothesis.inliers = inliersOf(verifier, query);
  const HeightFit heights = fitHeights(verifier.heightPairs(), query.hasHeights());
  const Eigen::Vector3d centre_in_map =
      Eigen::Vector3d(pose.x, pose.y, heights.offset) + map.origin();
  hypothesis.T_map_query = poseFromYaw(centre_in_map, pose.yaw) * tilted(heights.slope) *
                           Eigen::Translation3d(-query.centre());
  hypothesis.centre = {centre_in_map.x(), centre_in_map.y(), angleDifference(pose.yaw, 0),
                       scored.score};
  return hypothesis;
}

/// Proposes, verifies and describes.
ObjectSearchResult ObjectPlaceIndex::Index::searchWhole(const ObjectQuery& query,
                                                        const ObjectSearchRequest& request) const {
  if (query.items().empty()) return {};
  std::vector<Scored> poses = propose(query, request);
  const auto proposed = static_cast<int>(poses.size());
  verifyAll(poses.size(), request.threads, map, query, options,
            [&](ObjectVerifier& verifier, std::size_t i) {
              poses[i] = lookedAt(verifier, poses[i].pose);
            });
  keepDistinct(poses, static_cast<std::size_t>(options.refine_poses));
  ObjectSearchResult result = answer(query, std::move(poses), request);
  result.poses = proposed;
  return result;
}

/// Refines poses to the end, orders and describes them.
ObjectSearchResult ObjectPlaceIndex::Index::answer(const ObjectQuery& query,
                                                   std::vector<Scored> poses,
                                                   const ObjectSearchRequest& request) const {
  verifyAll(poses.size(), request.threads, map, query, options,
            [&](ObjectVerifier& verifier, std::size_t i) {
              poses[i] = refined(verifier, poses[i].pose);
            });
  const auto isElsewhere = [&](const Scored& s) {
    return !agreesWithPrior(query, request, s.pose);
  };
  poses.erase(std::remove_if(poses.begin(), poses.end(), isElsewhere), poses.end());
  keepDistinct(poses, poses.size());

  ObjectSearchResult result;
  result.vertices = static_cast<int>(query.items().size());
  result.hypotheses.resize(
      std::min(static_cast<std::size_t>(std::max(1, request.hypotheses)), poses.size()));
  verifyAll(result.hypotheses.size(), request.threads, map, query, options,
            [&](ObjectVerifier& verifier, std::size_t i) {
              result.hypotheses[i] = describe(verifier, query, poses[i], request);
            });
  result.wrong = describeWrong(result.hypotheses, poses, map.origin());
  return result;
}

/// The pose that a part suggests, refined on larger and larger parts: a small error of the heading
/// is a large one far away.
CentrePose ObjectPlaceIndex::Index::grown(const SemanticGraph& graph, QueryPart part,
                                          const ObjectQuery& whole,
                                          const Eigen::Isometry3d& T_map_part) const {
  const auto poseOf = [&](const ObjectQuery& query, const Eigen::Isometry3d& T) {
    const Eigen::Vector3d p = T * query.centre() - map.origin();
    return CentrePose{p.x(), p.y(), yawOf(T.linear())};
  };
  Eigen::Isometry3d T = T_map_part;
  for (part.radius *= kGrowth; part.radius < 2 * whole.radius(); part.radius *= kGrowth) {
    const ObjectQuery query(graph, map, options, part);
    ObjectVerifier verifier(map, query, options);
    const CentrePose pose = refined(verifier, poseOf(query, T)).pose;
    T = poseFromYaw(Eigen::Vector3d(pose.x, pose.y, 0) + map.origin(), pose.yaw) *
        Eigen::Translation3d(-query.centre());
  }
  return poseOf(whole, T);
}

/// For queries of many streets: dense parts are searched for, and the best places of each must
/// explain the rest as well.
ObjectSearchResult ObjectPlaceIndex::Index::searchInParts(
    const SemanticGraph& graph, const QueryPart& whole, const ObjectSearchRequest& request) const {
  const ObjectQuery query(graph, map, options, whole);
  // The point that the prior speaks of may be far from the part.
  ObjectSearchRequest anywhere = request;
  anywhere.prior.near.reset();
  anywhere.hypotheses = static_cast<int>(kGrown);
  std::vector<Scored> poses;
  int proposed = 0;
  for (const QueryPart& part : denseParts(graph, map, kParts)) {
    const ObjectSearchResult found = searchWhole(ObjectQuery(graph, map, options, part), anywhere);
    proposed += found.poses;
    for (std::size_t i = 0; i < std::min(kGrown, found.hypotheses.size()); ++i)
      poses.push_back({grown(graph, part, query, found.hypotheses[i].T_map_query), 0});
  }
  ObjectSearchResult result = answer(query, std::move(poses), request);
  result.poses = proposed;
  return result;
}

ObjectPlaceIndex::ObjectPlaceIndex(const SemanticGraph& map, const LabelSet& labels,
                                   const ObjectPlaceOptions& options)
    : index_(std::make_unique<Index>(map, labels, options)) {}
ObjectPlaceIndex::~ObjectPlaceIndex() = default;
ObjectPlaceIndex::ObjectPlaceIndex(ObjectPlaceIndex&&) noexcept = default;
ObjectPlaceIndex& ObjectPlaceIndex::operator=(ObjectPlaceIndex&&) noexcept = default;

ObjectSearchResult ObjectPlaceIndex::search(const SemanticGraph& graph,
                                            const ObjectSearchRequest& request) const {
  const QueryPart whole = wholeOf(graph, index_->map);
  if (whole.radius > kLargestWhole) return index_->searchInParts(graph, whole, request);
  return index_->searchWhole(ObjectQuery(graph, index_->map, index_->options, whole), request);
}

std::vector<ObjectHypothesis> ObjectPlaceIndex::score(
    const SemanticGraph& graph, const std::vector<Eigen::Isometry3d>& T_map_query,
    const ObjectSearchRequest& request) const {
  const Index& index = *index_;
  const ObjectQuery query(graph, index.map, index.options, wholeOf(graph, index.map));
  std::vector<ObjectHypothesis> hypotheses(T_map_query.size());
  verifyAll(
      T_map_query.size(), request.threads, index.map, query, index.options,
      [&](ObjectVerifier& verifier, std::size_t i) {
        const Eigen::Vector3d p = T_map_query[i] * query.centre() - index.map.origin();
        const Scored scored = refined(verifier, {p.x(), p.y(), yawOf(T_map_query[i].linear())});
        hypotheses[i] = index.describe(verifier, query, scored, request);
      });
  return hypotheses;
}

std::size_t ObjectPlaceIndex::size() const { return index_->map.points().size(); }

std::size_t ObjectPlaceIndex::bytes() const {
  return index_->map.bytes() + index_->fine.bytes() +
         (index_->coarse ? index_->coarse->bytes() : 0);
}

}  // namespace xview
