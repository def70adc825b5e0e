// SPDX-License-Identifier: BSD-3-Clause
#include "match/ground_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr int kRounds = 12;
constexpr double kFirstGate_m = 4, kLastGate_m = 0.15;  ///< of residuals that count in full
constexpr std::size_t kFewestCells = 30;
constexpr double kAlike = 30;  ///< so many cells err together: roads are smooth, and so is drift

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Takes points about the query centre to the map.
class Placed {
 public:
  Placed(const PlanField& field, const PlacePose& pose)
      : field_(field), pose_(pose), cos_(std::cos(pose.yaw)), sin_(std::sin(pose.yaw)) {}

  /// In map axes, about the centre.
  Eigen::Vector2d turned(double x, double y) const {
    return {cos_ * x - sin_ * y, sin_ * x + cos_ * y};
  }
  /// Measured height of the map at a turned point; NaN if there is none.
  float ground(const Eigen::Vector2d& p) const {
    const PlanField::Tile* tile = tileAt(p);
    return tile ? tile->ground[PlanField::cellInTile(cellX(p), cellY(p))] : kNone;
  }
  /// Level of the map around a turned point; NaN if there is none.
  float level(const Eigen::Vector2d& p) const {
    const PlanField::Tile* tile = tileAt(p);
    return tile ? tile->level : kNone;
  }

 private:
  std::int32_t cellX(const Eigen::Vector2d& p) const { return floorToCell(pose_.x + p.x()); }
  std::int32_t cellY(const Eigen::Vector2d& p) const { return floorToCell(pose_.y + p.y()); }
  std::int32_t floorToCell(double metres) const {
    return static_cast<std::int32_t>(std::floor(metres / field_.cellSize()));
  }
  const PlanField::Tile* tileAt(const Eigen::Vector2d& p) const {
    return field_.tileOfCell(cellX(p), cellY(p));
  }

  const PlanField& field_;
  PlacePose pose_;
  double cos_, sin_;
};

/// Height of the map above a point of the query, which lies at (x, y) from the centre in map axes.
struct Difference {
  double x = 0, y = 0, dz = 0;
};

/// Where the map has a height: height_of(turned point), NaN if it has none there.
template <class Point, class HeightOf>
std::vector<Difference> differences(const Placed& placed, const std::vector<Point>& points,
                                    const HeightOf& height_of) {
  std::vector<Difference> found;
  for (const Point& q : points) {
    const Eigen::Vector2d p = placed.turned(q.x, q.y);
    const float height = height_of(p);
    if (!std::isnan(height)) found.push_back({p.x(), p.y(), height - double{q.z}});
  }
  return found;
}

std::vector<Difference> measuredDifferences(const Placed& placed,
                                            const std::vector<PlanQuery::Ground>& ground) {
  return differences(placed, ground, [&](const Eigen::Vector2d& p) { return placed.ground(p); });
}

/// Of the level of the map above the ground below the samples, which may be known from what stands
/// on it only.
std::vector<Difference> roughDifferences(const Placed& placed,
                                         const std::vector<PlanQuery::Sample>& samples) {
  return differences(placed, samples, [&](const Eigen::Vector2d& p) { return placed.level(p); });
}

double medianHeight(const std::vector<Difference>& all) {
  std::vector<double> heights;
  for (const Difference& d : all) heights.push_back(d.dz);
  return medianOf(std::move(heights));
}

}  // namespace

/// Least squares with weights of Geman-McClure, whose gate narrows (graduated non-convexity).
GroundFit fitGround(const PlanField& field, const std::vector<PlanQuery::Ground>& ground,
                    const PlacePose& centre_pose, double slope_sigma) {
  GroundFit fit;
  const std::vector<Difference> cells = measuredDifferences(Placed(field, centre_pose), ground);
  if (cells.size() < kFewestCells) return fit;
  Eigen::Vector3d plane(medianHeight(cells), 0, 0);
  for (int round = 0; round < kRounds; ++round) {
    const double gate = std::max(
        kLastGate_m, kFirstGate_m * std::pow(kLastGate_m / kFirstGate_m, round / (0.6 * kRounds)));
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double weights = 0, squares = 0;
    for (const Difference& d : cells) {
      const Eigen::Vector3d J(1, d.x, d.y);
      const double r = d.dz - plane.dot(J);
      const double weight = 1 / std::pow(1 + r * r / (gate * gate), 2);
      H += weight * J * J.transpose();
      b += weight * r * J;
      weights += weight;
      squares += weight * r * r;
    }
    const double variance = kAlike * std::max(squares / weights, 1e-4);
    H /= variance;
    b /= variance;
    const double level = 1 / (slope_sigma * slope_sigma);
    H.diagonal().tail<2>().array() += level;
    b.tail<2>() -= level * plane.tail<2>();
    plane += H.ldlt().solve(b);
    fit.covariance = H.inverse();
    fit.cells = static_cast<int>(weights);
  }
  fit.height_m = plane(0);
  fit.slope = plane.tail<2>();
  return fit;
}

double heightOffset(const PlanField& field, const PlanQuery& query, const PlacePose& centre_pose) {
  const Placed placed(field, centre_pose);
  std::vector<Difference> found = measuredDifferences(placed, query.ground);
  if (found.empty()) found = roughDifferences(placed, query.fine);
  return found.empty() ? 0 : medianHeight(found);
}

}  // namespace xview
