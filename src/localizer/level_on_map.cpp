// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/level_on_map.h"

#include <cmath>

#include "localizer/query_in_map.h"

namespace xview {
namespace {

constexpr double kWidest_rad = 0.2;  ///< how far off level a query may be that was said to be level
constexpr double kClearSigmas = 3;   ///< by which ground refutes that
constexpr double kBentByDrift = 1.5;  ///< true error of a slope over that by its residuals
/// A turn by less than this number of sigmas of the prior is left to the refinement, which turns
/// points by that itself; without points ground that was seen from afar tells no better.
constexpr double kLevelEnoughOfPoints = 2, kLevelEnough = 0.5;

/// A rotation of the query, and its pose after that.
struct Tilt {
  Eigen::Quaterniond turn;
  Eigen::Isometry3d T_map_query;
  double sigma_rad = 0;
};

/// Lays the ground of the query on a slope of the map, about the middle of that ground.
Tilt tiltBy(const search::HeightFit& fit, const Eigen::Vector3d& middle_of_ground,
            const Eigen::Isometry3d& T_map_query) {
  const Eigen::Vector3d normal = Eigen::Vector3d(-fit.slope.x(), -fit.slope.y(), 1).normalized();
  const auto in_map = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
  const Eigen::Quaterniond yaw(T_map_query.linear());
  Eigen::Vector3d middle_in_map = T_map_query * middle_of_ground;
  middle_in_map.z() = middle_of_ground.z() + fit.height_m;
  Tilt tilt{yaw.conjugate() * in_map * yaw, T_map_query,
            kBentByDrift * std::sqrt(fit.covariance.bottomRightCorner<2, 2>().trace() / 2)};
  tilt.T_map_query.translation() = middle_in_map - yaw * (tilt.turn * middle_of_ground);
  return tilt;
}

/// Of a query whose up was measured that well.
std::optional<Tilt> measuredTilt(const search::FieldQuery& in_field,
                                 const Eigen::Isometry3d& T_map_query, double up_sigma_rad) {
  const search::HeightFit fit = in_field.fitHeights(T_map_query, up_sigma_rad);
  if (fit.cells == 0) return std::nullopt;
  return tiltBy(fit, in_field.centre(), T_map_query);
}

/// Of a query that was said or measured to be level to `prior_sigma_rad`; a street that slopes
/// fools the measurement, so that ground which clearly contradicts counts alone. Less than
/// `enough_rad` need not be turned.
std::optional<Tilt> tiltAgainstPrior(const search::FieldQuery& in_field,
                                     const Eigen::Isometry3d& T_map_query, double prior_sigma_rad,
                                     double enough_rad) {
  const search::HeightFit fit =
      in_field.fitHeights(T_map_query, std::max(kWidest_rad, prior_sigma_rad));
  if (fit.cells == 0) return std::nullopt;
  Eigen::Matrix2d covariance =
      kBentByDrift * kBentByDrift * fit.covariance.bottomRightCorner<2, 2>();
  covariance.diagonal().array() += prior_sigma_rad * prior_sigma_rad;
  const double off2 = fit.slope.dot(covariance.inverse() * fit.slope);
  if (off2 > kClearSigmas * kClearSigmas) return tiltBy(fit, in_field.centre(), T_map_query);
  const auto both = measuredTilt(in_field, T_map_query, prior_sigma_rad);
  const bool level = !both || Eigen::AngleAxisd(both->turn).angle() < enough_rad;
  return level ? std::nullopt : both;
}

void turnBy(const Tilt& tilt, const search::Field& field, LevelledQuery& levelled) {
  levelled.turn = tilt.turn * levelled.turn;
  levelled.query = tiltedQuery(levelled.query, tilt.turn);
  levelled.in_field = field.prepare(observationOf(levelled.query));
  levelled.T_map_query = tilt.T_map_query;
  levelled.up_sigma_rad = tilt.sigma_rad;
}

}  // namespace

search::Observation observationOf(const Query& query) {
  search::Observation seen;
  seen.bev = &query.bev;
  seen.graph = &query.graph;
  seen.focus = query.poses.back().translation();
  return seen;
}

std::unique_ptr<LevelledQuery> levelOnMap(const search::Field& field,
                                          const search::FieldQuery& in_field, const Query& query,
                                          const Eigen::Isometry3d& T_map_query, double up_sigma_rad,
                                          const Options& options) {
  if (options.gravity == "aligned") return nullptr;
  const double said_rad = options.refine.tilt_sigma_deg * M_PI / 180;
  const bool was_measured = up_sigma_rad > 0;
  const double enough_rad =
      was_measured ? 0 : said_rad * (query.cloud.empty() ? kLevelEnough : kLevelEnoughOfPoints);
  const std::optional<Tilt> tilt =
      tiltAgainstPrior(in_field, T_map_query, was_measured ? up_sigma_rad : said_rad, enough_rad);
  if (!tilt) return nullptr;
  auto levelled = std::make_unique<LevelledQuery>();
  levelled->query = query;
  turnBy(*tilt, field, *levelled);
  levelled->T_map_query = levelled->in_field->verify(levelled->T_map_query).T_map_query;
  if (const auto rest =
          measuredTilt(*levelled->in_field, levelled->T_map_query, levelled->up_sigma_rad))
    turnBy(*rest, field, *levelled);
  return levelled;
}

}  // namespace xview
