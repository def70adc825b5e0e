// SPDX-License-Identifier: BSD-3-Clause
#include "search/search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>

#include "base/median.h"
#include "base/parallel.h"
#include "base/pose.h"
#include "search/raster.h"
#include "xview/base/budget.h"

namespace xview::search {
namespace {

using Poses = std::vector<PlacePose>;

constexpr std::size_t kRefined = 30;  ///< distinct poses that are refined finely
constexpr double kSamePose_m = 1.5, kSamePose_rad = 0.05;  ///< poses this near have one maximum
/// What is just outside of a prior is nearer to it than another place (samePlace).
constexpr double kBeside_m = kSamePlace_m, kBeside_rad = kSamePlace_rad;
constexpr double kRounding = 1e-9;  ///< of a pose on the rim of a prior

/// The exhaustive search takes time with the third power of the radius of a query: finer steps of
/// yaw, more samples, more poses at which some of them meet the map.
constexpr double kWidest_cells = 100;
constexpr std::size_t kDenseParts = 3;  ///< dense parts of a wider query
constexpr double kPartsApart_m = 400;   ///< between their centres
constexpr double kPartCell_m = 75;      ///< in which its points are counted
constexpr std::size_t kEnough = 80;     ///< points that tell a place from all others
constexpr double kSmallestPart_m = 150, kLargestPart_m = 400;  ///< radius
constexpr std::size_t kGrown = 5;  ///< poses of each part that are tried on the whole
constexpr double kGrowth = 1.5;    ///< of the radius of a part, again and again

/// Best first; equal scores in the order of the plane.
bool isBetter(const PlacePose& a, const PlacePose& b) {
  return std::make_tuple(-a.score, a.y, a.x, a.yaw) < std::make_tuple(-b.score, b.y, b.x, b.yaw);
}

bool areOnePose(const PlacePose& a, const PlacePose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kSamePose_m &&
         std::abs(angleDifference(a.yaw, b.yaw)) < kSamePose_rad;
}

/// The best poses that differ from all better ones, best first.
template <class Same>
Poses distinct(Poses poses, std::size_t count, const Same& same) {
  std::sort(poses.begin(), poses.end(), isBetter);
  Poses kept;
  for (const PlacePose& p : poses) {
    if (kept.size() >= count) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const PlacePose& k) { return same(k, p); }))
      kept.push_back(p);
  }
  return kept;
}

void refineAll(const FieldQuery& query, RefinementLevel how, int threads, Poses& poses) {
  parallelFor(poses.size(), threads, [&](std::size_t i) {
    askBudget(kSearchStage);
    poses[i] = query.refineLocally(poses[i], how);
  });
}

/// Poses of the centre of one query as those of another centre of the same query frame.
void moveCentre(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Poses& poses) {
  for (PlacePose& p : poses) {
    const Eigen::Vector2d step = Eigen::Rotation2Dd(p.yaw) * (to - from).head<2>();
    p.x += step.x();
    p.y += step.y();
  }
}

bool satisfies(const PlacePrior& prior, const PlaceHypothesis& h, const Eigen::Vector3d& focus) {
  if (prior.heading && std::abs(angleDifference(h.centre.yaw, prior.heading->yaw)) >
                           prior.heading->tolerance + kRounding)
    return false;
  if (!prior.near) return true;
  const Eigen::Vector2d p = (h.T_map_query * focus).head<2>();
  return (p - Eigen::Vector2d(prior.near->x, prior.near->y)).norm() <=
         prior.near->radius + kRounding;
}

/// True if a pose satisfies all priors, or would if they were wider.
bool satisfiesAll(const std::vector<PlacePrior>& priors, const PlaceHypothesis& h,
                  const Eigen::Vector3d& focus, double wider_m, double wider_rad) {
  return std::all_of(priors.begin(), priors.end(), [&](PlacePrior prior) {
    if (prior.near) prior.near->radius += wider_m;
    if (prior.heading) prior.heading->tolerance += wider_rad;
    return satisfies(prior, h, focus);
  });
}

/// Distinct poses of positive score by the exhaustive search of the rasters, coarse to fine.
Poses proposals(const FieldQuery& query, RasterLevels levels, const PlacePrior& prior,
                int threads) {
  levels.threads = threads;
  levels.centre_prior = prior;
  if (levels.centre_prior.near) {
    levels.centre_prior.near->x -= query.origin().x();
    levels.centre_prior.near->y -= query.origin().y();
  }
  return searchRaster(levels);
}

/// Proposed poses, refined coarsely, thinned, and refined finely. Counts what was proposed.
Poses bestPoses(const FieldQuery& query, const RasterLevels& levels,
                const std::vector<PlacePrior>& priors, int threads, int& proposed) {
  Poses poses = proposals(
      query, levels, priorOfPoint(priors, (query.centre() - query.focus()).head<2>()), threads);
  proposed += static_cast<int>(poses.size());
  if (poses.size() > levels.refine_poses) {
    const auto best = poses.begin() + static_cast<std::ptrdiff_t>(levels.refine_poses);
    Poses others(best, poses.end());
    poses.erase(best, poses.end());
    refineAll(query, RefinementLevel::rough, threads, others);
    others = distinct(std::move(others), levels.refine_poses / 2, areOnePose);
    poses.insert(poses.end(), others.begin(), others.end());
  }
  refineAll(query, RefinementLevel::coarse, threads, poses);
  poses = distinct(std::move(poses), kRefined, areOnePose);
  refineAll(query, RefinementLevel::fine, threads, poses);
  return poses;
}

struct Disc {
  Eigen::Vector2d centre;
  double radius;
};

/// The smallest disc with enough points.
Disc discAround(const Eigen::Vector2d& centre, const std::vector<FieldQuery::Point>& points) {
  std::vector<double> distances;
  for (const FieldQuery::Point& k : points) distances.push_back((k.p - centre).norm());
  const double enough_m = rankedOf(distances, std::min(kEnough, distances.size()) - 1);
  return {centre, std::clamp(enough_m, kSmallestPart_m, kLargestPart_m)};
}

/// Where a query holds most points, by weight: densest first, apart from one another.
std::vector<Disc> denseParts(const std::vector<FieldQuery::Point>& points) {
  struct Sum {
    double weight = 0, count = 0;
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
  };
  std::map<std::pair<int, int>, Sum> around;  // of the 3x3 cells
  for (const FieldQuery::Point& k : points) {
    const int cx = static_cast<int>(std::floor(k.p.x() / kPartCell_m)),
              cy = static_cast<int>(std::floor(k.p.y() / kPartCell_m));
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        Sum& sum = around[{cy + dy, cx + dx}];
        sum.weight += k.weight;
        sum.count += 1;
        sum.p += k.p;
      }
    }
  }
  std::vector<std::pair<double, Eigen::Vector2d>> centres;
  for (const auto& [cell, sum] : around) centres.push_back({sum.weight, sum.p / sum.count});
  std::stable_sort(centres.begin(), centres.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Disc> parts;
  for (const auto& [weight, centre] : centres) {
    if (parts.size() >= kDenseParts) break;
    const auto isNear = [&, c = centre](const Disc& d) {
      return (d.centre - c).norm() < kPartsApart_m;
    };
    if (std::none_of(parts.begin(), parts.end(), isNear))
      parts.push_back(discAround(centre, points));
  }
  return parts;
}

/// The same of a query that is too wide for the exhaustive search: its dense parts are searched
/// for, and the poses are refined with ever more of the query around them, since a small error of
/// the heading is a large one far away.
Poses bestPosesOfWide(const FieldQuery& query, const std::vector<PlacePrior>& priors, int threads,
                      int& proposed) {
  Poses all;
  for (const Disc& disc : denseParts(query.points())) {
    std::unique_ptr<FieldQuery> part = query.part(disc.centre, disc.radius);
    if (part->empty()) continue;
    Poses poses = distinct(bestPoses(*part, part->rasterLevels(), priors, threads, proposed),
                           kGrown, areOnePose);
    const double whole_m = query.radius() + (disc.centre - query.centre().head<2>()).norm();
    for (double radius_m = disc.radius * kGrowth; radius_m < whole_m; radius_m *= kGrowth) {
      std::unique_ptr<FieldQuery> larger = query.part(disc.centre, radius_m);
      moveCentre(part->centre(), larger->centre(), poses);
      refineAll(*larger, RefinementLevel::fine, threads, poses);
      part = std::move(larger);
    }
    moveCentre(part->centre(), query.centre(), poses);
    all.insert(all.end(), poses.begin(), poses.end());
  }
  refineAll(query, RefinementLevel::fine, threads, all);
  return all;
}

/// Whether the best pose scores much less than a true one would: streets that are narrow beside the
/// cells of a raster may be missed by all that starts in these.
bool mayBeMissed(const FieldQuery& query, const Poses& poses) {
  constexpr double kLikeTrue = 0.6;
  const auto best = std::min_element(poses.begin(), poses.end(), isBetter);
  if (best == poses.end()) return true;
  const PlaceHypothesis h = query.describeAt(*best);
  return best->score < kLikeTrue * h.expected ||
         h.obstacles.score < kLikeTrue * h.obstacles.expected;
}

PlaceHypothesis describedIn(const FieldQuery& storey, const PlacePose& pose) {
  PlaceHypothesis described = storey.describeAt(pose);
  described.storey = storey.storey();
  return described;
}

/// search() in one storey.
SearchResult searchStorey(const FieldQuery& query, const std::vector<PlacePrior>& priors,
                          const SearchOptions& options, int threads) {
  SearchResult result;
  result.vertices = query.size();
  if (query.empty()) return result;
  const RasterLevels levels = query.rasterLevels();
  const bool is_wide = query.radius() > kWidest_cells * levels.fine.raster.cellSize();
  Poses poses = is_wide ? bestPosesOfWide(query, priors, threads, result.poses)
                        : bestPoses(query, levels, priors, threads, result.poses);
  if (!is_wide && mayBeMissed(query, poses)) {
    if (const std::unique_ptr<RasterLevels> finer = query.finerLevels()) {
      const Poses more = bestPoses(query, *finer, priors, threads, result.poses);
      poses.insert(poses.end(), more.begin(), more.end());
    }
  }
  const auto leavesPriors = [&](const PlacePose& p) {
    const PlaceHypothesis h = query.inMap(p);
    if (satisfiesAll(priors, h, query.focus(), 0, 0)) return false;
    if (satisfiesAll(priors, h, query.focus(), kBeside_m, kBeside_rad))
      result.outside = std::max(result.outside, p.score);
    return true;
  };
  poses.erase(std::remove_if(poses.begin(), poses.end(), leavesPriors), poses.end());
  poses = distinct(std::move(poses), poses.size(), samePlace);

  const std::size_t told =
      std::min(poses.size(), static_cast<std::size_t>(std::max(1, options.hypotheses)));
  for (const PlacePose& p : poses) result.places.push_back(query.inMap(p));
  parallelFor(told, threads, [&](std::size_t i) {
    askBudget(kSearchStage);
    result.places[i] = describedIn(query, query.refineLocally(poses[i], RefinementLevel::polish));
  });
  std::stable_sort(result.places.begin(), result.places.begin() + static_cast<std::ptrdiff_t>(told),
                   [](const auto& a, const auto& b) { return a.score() > b.score(); });
  return result;
}

}  // namespace

SearchResult search(const FieldQuery& query, const std::vector<PlacePrior>& priors,
                    const SearchOptions& options, int threads) {
  const std::vector<const FieldQuery*> storeys = query.storeys();
  if (storeys.size() == 1) return searchStorey(*storeys[0], priors, options, threads);
  SearchOptions in_full = options;  // a place without a height may be in any storey
  in_full.hypotheses = std::numeric_limits<int>::max();
  SearchResult all;
  for (const FieldQuery* storey : storeys) {
    SearchResult result = searchStorey(*storey, priors, in_full, threads);
    all.outside = std::max(all.outside, result.outside);
    all.poses += result.poses;
    all.vertices = result.vertices;
    std::move(result.places.begin(), result.places.end(), std::back_inserter(all.places));
  }
  std::stable_sort(all.places.begin(), all.places.end(),
                   [](const auto& a, const auto& b) { return a.score() > b.score(); });
  return all;
}

PlacePrior priorOfPoint(const std::vector<PlacePrior>& priors, const Eigen::Vector2d& lever) {
  PlacePrior result;
  for (const PlacePrior& p : priors) {
    if (p.heading && (!result.heading || p.heading->tolerance < result.heading->tolerance))
      result.heading = p.heading;
    if (p.near && (!result.near || p.near->radius < result.near->radius)) result.near = p.near;
  }
  if (!result.near) return result;
  const double chord =
      result.heading ? 2 * std::sin(std::min(result.heading->tolerance, M_PI) / 2) : 2;
  if (chord < 1) {
    const Eigen::Vector2d shift = Eigen::Rotation2Dd(result.heading->yaw) * lever;
    result.near->x += shift.x();
    result.near->y += shift.y();
  }
  result.near->radius += std::min(chord, 1.0) * lever.norm();
  return result;
}

PlacePose FieldQuery::centrePose(const Eigen::Isometry3d& T_map_query) const {
  const Eigen::Vector3d p = T_map_query * centre_ - origin_;
  return {p.x(), p.y(), yawOf(T_map_query.linear()), 0};
}

PlaceHypothesis FieldQuery::inMap(const PlacePose& centre_pose, double height_m) const {
  PlaceHypothesis h;
  h.centre = {centre_pose.x + origin_.x(), centre_pose.y + origin_.y(),
              angleDifference(centre_pose.yaw, 0), centre_pose.score};
  h.T_map_query = poseFromYaw({h.centre.x, h.centre.y, height_m}, h.centre.yaw) *
                  Eigen::Translation3d(-centre_);
  return h;
}

double FieldQuery::score(const Eigen::Isometry3d& T_map_query) const {
  const FieldQuery& here = at(T_map_query);
  return here.scoreAt(here.centrePose(T_map_query));
}

PlaceHypothesis FieldQuery::describe(const Eigen::Isometry3d& T_map_query) const {
  const FieldQuery& here = at(T_map_query);
  PlacePose pose = here.centrePose(T_map_query);
  pose.score = here.scoreAt(pose);
  return describedIn(here, pose);
}

PlaceHypothesis FieldQuery::verify(const Eigen::Isometry3d& T_map_query) const {
  const FieldQuery& here = at(T_map_query);
  PlacePose pose = here.centrePose(T_map_query);
  for (const RefinementLevel how :
       {RefinementLevel::coarse, RefinementLevel::fine, RefinementLevel::polish})
    pose = here.refineLocally(pose, how);
  return describedIn(here, pose);
}

HeightFit FieldQuery::fitHeights(const Eigen::Isometry3d& /*T_map_query*/,
                                 double /*slope_sigma*/) const {
  return {};
}

std::vector<SampleEvidence> FieldQuery::evidence(const Eigen::Isometry3d& /*T_map_query*/) const {
  return {};
}

std::unique_ptr<RasterLevels> FieldQuery::finerLevels() const { return nullptr; }

Visibility FieldQuery::visibility(const Eigen::Isometry3d& /*T_map_query*/) const { return {}; }

}  // namespace xview::search
