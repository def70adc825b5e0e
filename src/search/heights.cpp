// SPDX-License-Identifier: BSD-3-Clause
#include "search/heights.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/median.h"

namespace xview::search {
namespace {

constexpr int kRounds = 12;
constexpr double kNarrowing = 0.6;           ///< share of the rounds in which the gate narrows
constexpr double kFirstGate_m = 4;           ///< of residuals that count in full
constexpr double kVertexSlope = 0.02;        ///< [rad] how far off level bare graphs are
constexpr double kFreedom = 3;               ///< of the t distribution of heights off the plane
constexpr double kIndependentHeights = 0.7;  ///< of what heights say: neighbours are off together

constexpr double kGroundSigma_m = 1;  ///< only residuals tell how much ground is really off
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

double residual(const HeightPair& p, const Eigen::Vector3d& plane) {
  return p.rise - plane.dot(Eigen::Vector3d(1, p.x, p.y));
}

/// Takes points about the query centre to the map.
class Placed {
 public:
  Placed(const DistanceField& field, const PlacePose& pose)
      : field_(field), pose_(pose), cos_(std::cos(pose.yaw)), sin_(std::sin(pose.yaw)) {}

  /// In map axes, about the centre.
  Eigen::Vector2d turned(double x, double y) const {
    return {cos_ * x - sin_ * y, sin_ * x + cos_ * y};
  }
  /// Measured height of the map at a turned point; NaN if there is none.
  float ground(const Eigen::Vector2d& p) const {
    const DistanceField::Tile* tile = tileAt(p);
    return tile ? tile->ground[DistanceField::cellInTile(cellX(p), cellY(p))] : kNone;
  }
  /// Level of the map around a turned point; NaN if there is none.
  float level(const Eigen::Vector2d& p) const {
    const DistanceField::Tile* tile = tileAt(p);
    return tile ? tile->level : kNone;
  }

 private:
  std::int32_t cellX(const Eigen::Vector2d& p) const { return floorToCell(pose_.x + p.x()); }
  std::int32_t cellY(const Eigen::Vector2d& p) const { return floorToCell(pose_.y + p.y()); }
  std::int32_t floorToCell(double metres) const {
    return static_cast<std::int32_t>(std::floor(metres / field_.cellSize()));
  }
  const DistanceField::Tile* tileAt(const Eigen::Vector2d& p) const {
    return field_.tileOfCell(cellX(p), cellY(p));
  }

  const DistanceField& field_;
  PlacePose pose_;
  double cos_, sin_;
};

/// Heights of the map above points of the query, where the map has one: height_of(turned point) is
/// NaN elsewhere.
template <class Point, class HeightOf>
std::vector<HeightPair> pairsOf(const Placed& placed, const std::vector<Point>& points,
                                const HeightOf& height_of) {
  std::vector<HeightPair> found;
  for (const Point& q : points) {
    const Eigen::Vector2d p = placed.turned(q.x, q.y);
    const float height = height_of(p);
    if (!std::isnan(height))
      found.push_back({p.x(), p.y(), double{height} - double{q.z}, kGroundSigma_m});
  }
  return found;
}

}  // namespace

HeightModel groundHeights(double slope_sigma) { return {slope_sigma, 30, 0.15, 30, 1e-4}; }
HeightModel vertexHeights() { return {kVertexSlope, 6, std::sqrt(2.0), 1, 1}; }

double medianRise(const std::vector<HeightPair>& pairs) {
  std::vector<double> rises;
  for (const HeightPair& p : pairs) rises.push_back(p.rise);
  return rises.empty() ? 0 : medianOf(std::move(rises));
}

HeightFit fitHeights(const std::vector<HeightPair>& pairs, const HeightModel& model) {
  HeightFit fit;
  fit.height_m = medianRise(pairs);
  if (pairs.size() < model.fewest) return fit;
  Eigen::Vector3d plane(fit.height_m, 0, 0);
  const double level = 1 / (model.slope_sigma * model.slope_sigma);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double weights = 0, squares = 0;
    for (const HeightPair& p : pairs) {
      const double first = kFirstGate_m / p.sigma;
      const double gate =
          std::max(model.last_gate,
                   first * std::pow(model.last_gate / first, round / (kNarrowing * kRounds)));
      const Eigen::Vector3d J = Eigen::Vector3d(1, p.x, p.y) / p.sigma;
      const double r = residual(p, plane) / p.sigma, outlying = 1 + r * r / (gate * gate);
      const double weight = 1 / (outlying * outlying);
      H += weight * J * J.transpose();
      b += weight * r * J;
      weights += weight;
      squares += weight * r * r;
    }
    const double variance = model.alike * std::max(squares / weights, model.least_variance);
    H /= variance;
    b /= variance;
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

double heightCost(const std::vector<HeightPair>& pairs, const HeightFit& fit) {
  const Eigen::Vector3d plane(fit.height_m, fit.slope.x(), fit.slope.y());
  double cost = 2 * std::log1p(0.5 * fit.slope.squaredNorm() / (kVertexSlope * kVertexSlope));
  for (const HeightPair& p : pairs) {
    const double off = residual(p, plane) / p.sigma;
    cost += kIndependentHeights * p.weight * std::log1p(off * off / kFreedom);
  }
  return cost;
}

std::vector<HeightPair> groundPairs(const DistanceField& field,
                                    const std::vector<SurfaceSamples::Ground>& ground,
                                    const PlacePose& pose) {
  const Placed placed(field, pose);
  return pairsOf(placed, ground, [&](const Eigen::Vector2d& p) { return placed.ground(p); });
}

double heightOffset(const DistanceField& field, const SurfaceSamples& samples,
                    const PlacePose& pose) {
  const Placed placed(field, pose);
  std::vector<HeightPair> found = groundPairs(field, samples.ground, pose);
  if (found.empty())
    found =
        pairsOf(placed, samples.fine, [&](const Eigen::Vector2d& p) { return placed.level(p); });
  return medianRise(found);
}

}  // namespace xview::search
