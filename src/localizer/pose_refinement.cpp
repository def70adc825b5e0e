// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/pose_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/median.h"
#include "base/pose.h"
#include "map/contents.h"
#include "pose/free_space_violation.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"

namespace xview {
namespace {

/// A distribution has four cells of a BEV grid. Samples err by about half a cell; a grid says
/// nothing of tilt.
pose::RefineOptions bevRefinement() {
  pose::RefineOptions options;
  options.cell_m = 2;
  options.model.roughness_m = 0.3;
  options.model.first_gate_m = 1.5;
  options.model.last_gate_m = 1.2;
  options.tilt_sigma_deg = 0.01;
  options.model.drift_share = 0;
  options.model.start_reach_m = 0;
  return options;
}

/// Every channel is a class that matches itself only.
LabelSet bevChannelClasses() {
  LabelSet classes("channels");
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    ClassInfo info;
    info.id = static_cast<std::uint32_t>(c);
    info.name = toString(static_cast<BevChannel>(c));
    info.role = Role::surface;
    info.kind = Kind::other_surface;
    classes.add(info);
  }
  return classes;
}

/// Samples at height 0. Areas are left out: their borders are channels of their own, and where an
/// area ends without one nothing more was seen.
LabelledCloud flatCloud(const BevGrid& view, const Eigen::Vector2d& centre, double reach_m) {
  LabelledCloud cloud;
  cloud.origin = {view.origin_x, view.origin_y, 0};
  const Eigen::Vector2d from_origin = centre - cloud.origin.head<2>();
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (isArea(static_cast<BevChannel>(c))) continue;
    for (const BevSample& s : view.samples[c]) {
      if ((Eigen::Vector2d(s.x, s.y) - from_origin).norm() <= reach_m)
        cloud.points.emplace_back(s.x, s.y, 0.F, static_cast<std::uint32_t>(c));
    }
  }
  return cloud;
}

/// The pose in the plane: x, y and yaw.
Eigen::Isometry3d planarPart(const Eigen::Isometry3d& T) {
  return poseFromYaw({T.translation().x(), T.translation().y(), 0}, yawOf(T.linear()));
}

/// Standard deviation of a pair of vertices. A pose with too few pairs has the uncertainty of the
/// place search, kVague_m and kVague_rad.
constexpr double kPairSigma_m = 0.5, kVague_m = 5, kVague_rad = 0.5;
/// Uncertainty of the BEV grid of the last metres: samples lie about that far apart, heights are
/// those of distant ground, and a short part of a window tells the yaw no better.
constexpr double kBevSigma_m = 0.25, kBevHeightSigma_m = 0.3, kBevYawSigma_rad = 0.01;
/// Share of its score that a pose must keep when it is moved, of the last metres and of the whole
/// window. The last metres alone may fit some metres further as well.
constexpr double kScoreKept = 0.25;
/// Standard deviations of a pose by registered BEV grids up to kBevSeenFrom_m above ground; above
/// it they grow with the square of the height, as errors of depth do. Along the path odometry has
/// drifted since the grid was seen, some 25 m before. Tilt is that of the odometry.
constexpr double kBevSeenFrom_m = 45;
constexpr double kBevAlong_m = 0.25, kBevAcross_m = 0.11, kBevUp_m = 0.12, kBevTilt_rad = 0.0025,
                 kBevTurn_rad = 0.0065;

/// Each pair fixes its vertex with kPairSigma_m.
Matrix6d covarianceOfPairs(const std::vector<Correspondence>& pairs, const AllVertices& in_map,
                           const Eigen::Vector3d& sensor_in_map) {
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>().diagonal().setConstant(1 / (kVague_m * kVague_m));
  information.bottomRightCorner<3, 3>().diagonal().setConstant(1 / (kVague_rad * kVague_rad));
  for (const Correspondence& c : pairs) {
    const Eigen::Vector3d v = in_map.at(c.map).position - sensor_in_map;
    Eigen::Matrix<double, 3, 6> J;
    J.leftCols<3>() = Eigen::Matrix3d::Identity();
    J.rightCols<3>() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0;
    information += J.transpose() * J / (kPairSigma_m * kPairSigma_m);
  }
  return information.inverse();
}

/// Position of a frame among the poses of the query; the last one if it is not among them.
std::size_t poseOfFrame(const Query& query, std::int64_t frame) {
  const auto found = std::lower_bound(query.frames.begin(), query.frames.end(), frame);
  const auto at = static_cast<std::size_t>(found - query.frames.begin());
  return std::min(at, query.poses.size() - 1);
}

/// The correspondences as the back-end of the paper wants them: vertices as the query saw them,
/// their partners in the map.
std::vector<pose::MatchedVertex> matchedVertices(const Query& query, const AllVertices& in_map,
                                                 const std::vector<Correspondence>& kept) {
  std::vector<pose::MatchedVertex> matched;
  for (const Correspondence& pair : kept) {
    const Vertex& seen = query.graph.vertices[pair.query];
    const Vertex known = in_map.at(pair.map);
    pose::MatchedVertex vertex;
    vertex.p_odom = seen.position;
    vertex.sigma_m = seen.sigma_m;
    vertex.first_pose = poseOfFrame(query, seen.first_frame);
    vertex.last_pose = std::max(vertex.first_pose, poseOfFrame(query, seen.last_frame));
    vertex.p_map = known.position;
    vertex.map_covariance = known.sigma_m * known.sigma_m * Eigen::Matrix3d::Identity();
    matched.push_back(vertex);
  }
  return matched;
}

/// Level direction of the last metres of travel, map frame; zero if the sensor stood.
Eigen::Vector3d recentTravel(const Query& query, const Eigen::Isometry3d& T_map_query) {
  constexpr double kEnough_m = 2;
  const Eigen::Vector3d last = query.poses.back().translation();
  for (std::size_t i = query.poses.size(); i-- > 0;) {
    Eigen::Vector3d way = T_map_query.linear() * (last - query.poses[i].translation());
    way.z() = 0;
    if (way.norm() > kEnough_m) return way.normalized();
  }
  return Eigen::Vector3d::Zero();
}

/// The last of the poses from which half of the way, or half of its last `at_most_m`, is left.
std::size_t halfway(const std::vector<Eigen::Isometry3d>& poses, double at_most_m) {
  const std::vector<double> way_m = pathLengths(poses);
  const double from_m = way_m.back() - 0.5 * std::min(at_most_m, way_m.back());
  const auto after = std::upper_bound(way_m.begin(), way_m.end(), from_m);
  return static_cast<std::size_t>(after - way_m.begin()) - 1;
}

/// Height of the last sensor over the ground that the query has measured; 0 if there is none.
double heightOverGround(const Query& query) {
  std::vector<float> heights;
  for (const GroundCell& cell : query.bev.known) {
    if (cell.measured) heights.push_back(cell.z);
  }
  if (heights.empty()) return 0;
  const Eigen::Vector3d sensor = query.bev.alignment * query.poses.back().translation();
  return sensor.z() - query.bev.origin_z - medianOf(std::move(heights));
}

/// Covariance of a pose by registered BEV grids: long along the path, short across it.
Matrix6d covarianceOfBev(const Query& query, const Eigen::Isometry3d& T_map_query,
                         double up_sigma_rad) {
  const double higher = std::max(1.0, std::pow(heightOverGround(query) / kBevSeenFrom_m, 2));
  const double along_m = higher * kBevAlong_m, across_m = higher * kBevAcross_m;
  const double tilt_rad = std::hypot(kBevTilt_rad, up_sigma_rad);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << across_m, across_m, higher * kBevUp_m, tilt_rad, tilt_rad, kBevTurn_rad;
  Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  const Eigen::Vector3d travel = recentTravel(query, T_map_query);
  covariance.topLeftCorner<3, 3>() +=
      (along_m * along_m - across_m * across_m) * travel * travel.transpose();
  return covariance;
}

void setInlierRatio(const std::optional<pose::Agreement>& agreement, DenseEvidence& dense) {
  dense.converged = agreement.has_value();
  if (!agreement) return;
  dense.inlier_ratio = agreement->found;
  dense.null_inlier_ratio = agreement->null_inlier_ratio;
}

}  // namespace

const pose::DistributionMap& BevRegistration::distributions() const {
  std::call_once(made_, [&] {
    distributions_.emplace(
        flatCloud(map_(), Eigen::Vector2d::Zero(), std::numeric_limits<double>::infinity()),
        bevChannelClasses(), std::vector<Eigen::Isometry3d>(), bevRefinement());
  });
  return *distributions_;
}

std::optional<RegisteredBev> BevRegistration::align(const BevGrid& query,
                                                    const Eigen::Vector3d& sensor_in_query,
                                                    const Eigen::Isometry3d& T_map_query) const {
  const Eigen::Isometry3d up_of_map(alignment_), up_of_query(query.alignment);
  const Eigen::Isometry3d before = planarPart(up_of_map * T_map_query * up_of_query.inverse());
  Eigen::Isometry3d sensor = Eigen::Isometry3d::Identity();
  sensor.translation().head<2>() = (up_of_query * sensor_in_query).head<2>();
  const LabelledCloud cloud = flatCloud(query, sensor.translation().head<2>(), kRecent_m);
  const std::vector<Eigen::Isometry3d> poses{sensor};
  const pose::Refinement found = pose::refine(distributions(), pose::RefineQuery{cloud, poses},
                                              bevChannelClasses(), before, bevRefinement());
  if (!found.converged) return std::nullopt;
  const Eigen::Isometry3d motion = planarPart(found.T_map_query) * before.inverse();
  return RegisteredBev{up_of_map.inverse() * motion * up_of_map * T_map_query, found.agreement};
}

/// A pose on its way through the steps.
struct PoseRefinement::Step {
  const Query& query;
  const search::FieldQuery* whole;                   ///< null without BEV grids
  const std::unique_ptr<search::FieldQuery> recent;  ///< its last metres
  const double least_score;                          ///< of the whole
  const double up_sigma_rad;
  const double max_shift_m;
  RefinedPose pose;

  double shiftTo(const Eigen::Isometry3d& T) const {
    const Eigen::Vector3d sensor = query.poses.back().translation();
    return (T * sensor - pose.T_map_query * sensor).norm();
  }
  /// True if the BEV grids do not contradict the new pose.
  bool keepsScore(const Eigen::Isometry3d& T, double share) const {
    return !whole || (recent->score(T) >= share * recent->score(pose.T_map_query) &&
                      whole->score(T) >= least_score);
  }
  /// The same for a window that has drifted: its last metres and the whole of it are scored at the
  /// poses of their middles, and the sum of both scores counts.
  bool keepsScore(const pose::Refinement& refined) const {
    const auto at = [&](double way_m) -> const Eigen::Isometry3d& {
      return refined.T_map_query_at[halfway(query.poses, way_m)];
    };
    return !whole || recent->score(at(kRecent_m)) + whole->score(at(INFINITY)) >=
                         kScoreKept * recent->score(pose.T_map_query) + least_score;
  }
};

pose::DistributionMap distributionsOf(const map::SemanticMap& map,
                                      const pose::RefineOptions& options) {
  return {{map.cloud, map.labels, map.poses, map.stored_points.get(), map.noise}, options};
}

PoseRefinement::PoseRefinement(const map::SemanticMap& map, const Options& options)
    : map_(map), options_(options), bev_(map) {
  if (!options.refine.enabled || map::countsOf(map).points == 0) return;
  distributions_.emplace(distributionsOf(map, options.refine));
}

/// The paper's back-end: odometry between the poses of the window, vertices, their partners.
void PoseRefinement::usePosterior(const std::vector<Correspondence>& kept, Step& step) const {
  pose::PosteriorOptions options = options_.posterior;
  double& gravity_sigma_rad = options.model.gravity_sigma_rad;
  gravity_sigma_rad = std::hypot(gravity_sigma_rad, step.up_sigma_rad);
  pose::Posterior posterior = pose::maximizePosterior(
      step.query.poses, matchedVertices(step.query, map::allVertices(map_), kept),
      step.pose.T_map_query, options);
  if (!posterior.converged) return;
  const Eigen::Isometry3d T = posterior.T_map_sensor.back() * step.query.poses.back().inverse();
  if (step.shiftTo(T) >= step.max_shift_m || !step.keepsScore(T, 1)) return;
  step.pose.T_map_query = T;
  step.pose.covariance = posterior.covariance;
  step.pose.T_map_sensor = std::move(posterior.T_map_sensor);
}

void PoseRefinement::useRecentPart(Step& step) const {
  if (!step.recent) return;
  const Eigen::Isometry3d T = step.recent->verify(step.pose.T_map_query).T_map_query;
  if (step.shiftTo(T) < step.max_shift_m && step.keepsScore(T, 1)) step.pose.T_map_query = T;
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << kBevSigma_m, kBevSigma_m, kBevHeightSigma_m, 0, 0, kBevYawSigma_rad;
  step.pose.covariance.diagonal() += sigma.cwiseAbs2();
}

/// The clouds take the nearest surface for the right one, and see only some classes.
void PoseRefinement::useClouds(Step& step) const {
  step.pose.dense.of = DenseEvidence::Of::points;
  const Query& query = step.query;
  pose::RefineOptions options = options_.refine;
  options.tilt_sigma_deg = std::hypot(options.tilt_sigma_deg, step.up_sigma_rad * 180 / M_PI);
  const pose::Refinement refined = pose::refine(*distributions_, {query.cloud, query.poses},
                                                query.labels, step.pose.T_map_query, options);
  if (!refined.converged || !step.keepsScore(refined)) return;
  step.pose.T_map_query = refined.T_map_query;
  step.pose.covariance = refined.covariance;
  setInlierRatio(refined.agreement, step.pose.dense);
}

/// For points that are too uncertain to be registered: their averages in the BEV grid are.
void PoseRefinement::useBev(Step& step) const {
  step.pose.dense.of = DenseEvidence::Of::views;
  const Query& query = step.query;
  const auto found = bev_.align(query.bev, query.poses.back().translation(), step.pose.T_map_query);
  if (!found || step.shiftTo(found->T_map_query) >= step.max_shift_m ||
      !step.keepsScore(found->T_map_query, kScoreKept))
    return;
  step.pose.T_map_query = found->T_map_query;
  step.pose.covariance = covarianceOfBev(query, found->T_map_query, step.up_sigma_rad);
  setInlierRatio(found->agreement, step.pose.dense);
}

RefinedPose PoseRefinement::refine(const Query& query, const search::FieldQuery* in_field,
                                   const Eigen::Isometry3d& T_map_query,
                                   const std::vector<Correspondence>& kept, double up_sigma_rad,
                                   Timings& timing_ms) const {
  Stopwatch watch;
  const Eigen::Vector3d sensor = query.poses.back().translation();
  Step step{query,
            in_field,
            in_field ? in_field->part(sensor.head<2>(), kRecent_m) : nullptr,
            in_field ? kScoreKept * in_field->score(T_map_query) : 0,
            up_sigma_rad,
            options_.refine.max_shift_m,
            {}};
  step.pose.T_map_query = T_map_query;
  step.pose.covariance = covarianceOfPairs(kept, map::allVertices(map_), T_map_query * sensor);
  if (options_.posterior.enabled) {
    usePosterior(kept, step);
    timing_ms.emplace_back("posterior", watch.lap_ms());
  }
  if (options_.refine.enabled) {
    useRecentPart(step);
    if (!query.cloud.empty() && distributions_)
      useClouds(step);
    else if (step.recent && in_field->storeys().size() == 1)  // the view has all floors in one
      useBev(step);
    timing_ms.emplace_back("refine", watch.lap_ms());
  }
  return std::move(step.pose);
}

std::optional<double> PoseRefinement::selfConsistency(const Query& query) const {
  if (query.cloud.empty() || !distributions_) return std::nullopt;
  return pose::selfConsistency({query.cloud, query.poses}, query.labels, options_.refine);
}

std::optional<double> PoseRefinement::freeSpaceViolation(
    const Query& query, const Eigen::Isometry3d& T_map_query) const {
  if (query.cloud.empty() || !distributions_) return std::nullopt;
  return pose::freeSpaceViolation(*distributions_, {query.cloud, query.poses}, query.labels,
                                  T_map_query);
}

}  // namespace xview
