// SPDX-License-Identifier: BSD-3-Clause
#include "place/shapes_any_way_up.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/median.h"
#include "base/moments.h"
#include "place/gravity.h"
#include "place/shapes.h"
#include "place/up_by_surfaces.h"

namespace xview {
namespace {

constexpr double kLittleGround = 0.15;  ///< share of a cloud; less makes one ask which way is up
constexpr double kLittleGroundOfScan = 0.3;  ///< half of a scan is ground, a fifth if it hangs
constexpr double kMostGround = 0.8;          ///< share of a cloud that shows things on it
constexpr float kUnderScanner_m = 25;        ///< ground farther away may be another slope
constexpr double kFewestOfGround = 50;       ///< points of a plane
constexpr double kSteepStreet_rad = 0.15;  ///< ground that leans more is that of a leaning scanner
constexpr double kDoubtfulGround = 0.2;    ///< the same of a town, where surfaces are asked
constexpr double kMuchFoliage = 0.5;       ///< share of a cloud: leaning surfaces are of no shape
constexpr float kClearlyOff_m = 0.5;       ///< above ground or below it
/// Ground of another way up over that of the given one, at least; the second where surfaces tell
/// what is vertical.
constexpr double kMuchMore = 2, kFarMore = 4;

double shareOf(Shape shape, const pcl::PointCloud<Point>& points) {
  const auto count = std::count_if(points.begin(), points.end(), [&](const Point& point) {
    return point.label == static_cast<std::uint32_t>(shape);
  });
  return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

/// Median height of the ground of points that lie turned; nothing without ground.
std::optional<float> groundLevel(const Eigen::Matrix3d& R, const pcl::PointCloud<Point>& points) {
  const Eigen::RowVector3f up = R.row(2).cast<float>();
  std::vector<float> ground;
  for (const Point& point : points) {
    if (point.label == static_cast<std::uint32_t>(Shape::ground))
      ground.push_back(up * point.getVector3fMap());
  }
  if (ground.empty()) return std::nullopt;
  return medianOf(std::move(ground));
}

/// Whether more of the points lies above their ground than below it, as they lie when turned; of a
/// scan, which shows its ground from above, whether the scanner does.
bool standsOnGround(const Eigen::Matrix3d& R, Sensor sensor, const pcl::PointCloud<Point>& points) {
  const std::optional<float> level = groundLevel(R, points);
  if (!level) return false;
  if (sensor == Sensor::lidar) return *level < 0;
  const Eigen::RowVector3f up = R.row(2).cast<float>();
  std::ptrdiff_t more_above = 0;
  for (const Point& point : points) {
    const float height = up * point.getVector3fMap() - *level;
    more_above += (height > kClearlyOff_m) - (height < -kClearlyOff_m);
  }
  return more_above >= 0;
}

/// The normal of the plane through the ground within this distance of the origin; zero if it is not
/// seen. Of every step-th point.
Eigen::Vector3d groundNormal(const pcl::PointCloud<Point>& points, float reach_m,
                             std::size_t step) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), normal = mean;
  double gate_m = INFINITY;
  for (int round = 0; round < 5; ++round) {
    Moments3 ground;
    for (std::size_t i = 0; i < points.size(); i += step) {
      const Eigen::Vector3d p = points[i].getVector3fMap().cast<double>();
      if (points[i].label == static_cast<std::uint32_t>(Shape::ground) && p.norm() < reach_m &&
          std::abs(normal.dot(p - mean)) <= gate_m)
        ground.add(p, 1);
    }
    if (ground.count < kFewestOfGround) return Eigen::Vector3d::Zero();
    const auto axes = ground.axes();
    mean = ground.mean();
    normal = axes.eigenvectors().col(0);
    gate_m = std::max(0.2, 2 * std::sqrt(std::max(0.0, axes.eigenvalues()(0))));
  }
  return normal;
}

/// A cloud as it is labelled when it lies turned.
struct TurnedCloud {
  Eigen::Matrix3d R;
  pcl::PointCloud<Point> points;
  double ground = 0;  ///< share of it

  TurnedCloud(const Eigen::Matrix3d& turn, double size, pcl::PointCloud<Point> cloud)
      : R(turn), points(std::move(cloud)) {
    labelTurned(R, size, points);
    ground = shareOf(Shape::ground, points);
  }

  /// Whether little looks as it would if it lay upright.
  bool isDoubtful(Sensor sensor) const {
    const bool is_scan = sensor == Sensor::lidar;
    if (ground < (is_scan ? kLittleGroundOfScan : kDoubtfulGround) ||
        shareOf(Shape::foliage, points) > kMuchFoliage)
      return true;
    constexpr std::size_t kEnough = 10000;
    const Eigen::Vector3d normal =
        groundNormal(points, is_scan ? kUnderScanner_m : INFINITY, 1 + points.size() / kEnough);
    return !normal.isZero() && std::abs((R * normal).z()) < std::cos(kSteepStreet_rad);
  }
};

/// A cloud as it lies along this vertical. Up is where more ground is seen, with things on it; of a
/// lean it is the side of the axis if much ground is.
TurnedCloud along(const Eigen::Vector3d& vertical, bool is_lean, Sensor sensor, double size,
                  pcl::PointCloud<Point> points) {
  TurnedCloud best(alignmentFromUp(vertical).toRotationMatrix(), size, points);
  if (is_lean && best.ground > kLittleGroundOfScan && standsOnGround(best.R, sensor, best.points))
    return best;
  TurnedCloud other(alignmentFromUp(-vertical).toRotationMatrix(), size, std::move(points));
  const auto weight = [&](const TurnedCloud& cloud) {
    return std::make_pair(standsOnGround(cloud.R, sensor, cloud.points), cloud.ground);
  };
  return std::move(weight(best) < weight(other) ? other : best);
}

/// Turns a cloud by quarters if it shows `more` times its ground then, and upside down, of which
/// surfaces say the same, if it shows kMuchMore times its ground.
void turnByGround(Sensor sensor, double size, double more, TurnedCloud& best) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  std::vector<Eigen::AngleAxisd> turns = {{M_PI / 2, x}, {-M_PI / 2, x}};
  if (sensor == Sensor::lidar || size == kTownScale)
    turns.insert(turns.end(), {{M_PI / 2, y}, {-M_PI / 2, y}, {M_PI, x}});
  const Eigen::Matrix3d R = best.R;
  const double ground = best.ground;
  for (const Eigen::AngleAxisd& turn : turns) {
    TurnedCloud other(R * turn.toRotationMatrix(), size, best.points);
    const double least = (turn.angle() == M_PI ? kMuchMore : more) * ground;
    if (other.ground >= std::max({kLittleGround, least, best.ground}) &&
        other.ground <= kMostGround && standsOnGround(other.R, sensor, other.points))
      best = std::move(other);
  }
}

}  // namespace

Eigen::Vector3d labelAnyWayUp(const Eigen::Matrix3d& R_up_sensor, Sensor sensor, double size,
                              pcl::PointCloud<Point>& points) {
  const bool is_scan = sensor == Sensor::lidar;
  if (sensor == Sensor::cloud && size != kTownScale && R_up_sensor.isIdentity()) {
    const VerticalOfRoom vertical = verticalOfRoom(points, size);
    const bool is_z = vertical.axis == Eigen::Vector3d::UnitZ();
    if (is_z || vertical.is_up) {
      labelTurned(alignmentFromUp(vertical.axis).toRotationMatrix(), size, points);
      return is_z ? Eigen::Vector3d::Zero() : vertical.axis;
    }
    if (!vertical.axis.isZero()) {
      TurnedCloud best = along(vertical.axis, false, sensor, size, std::move(points));
      points = std::move(best.points);
      return best.R.row(2);
    }
  }
  TurnedCloud best(R_up_sensor, size, std::move(points));
  OtherVertical other_vertical;
  if ((is_scan || size == kTownScale) && best.isDoubtful(sensor))
    other_vertical = otherVertical(best.R.row(2), size, best.points);
  const bool tells = !other_vertical.axis.isZero();
  if (tells && other_vertical.axis != best.R.row(2).transpose()) {
    TurnedCloud other =
        along(other_vertical.axis, other_vertical.is_lean, sensor, size, best.points);
    const bool has_ground = other.ground > kFarMore * best.ground && other.ground < kMostGround;
    if (other_vertical.is_clear || has_ground) {
      points = std::move(other.points);
      return other.R.row(2);
    }
  }
  if (best.ground < (is_scan ? kLittleGroundOfScan : kLittleGround))
    turnByGround(sensor, size, tells ? kFarMore : kMuchMore, best);
  points = std::move(best.points);
  return Eigen::Vector3d::Zero();
}

/// Without a turn they are not copied: a cloud may be all that memory holds.
void labelTurned(const Eigen::Matrix3d& R, double size, pcl::PointCloud<Point>& points) {
  if (R == Eigen::Matrix3d::Identity()) return labelByShape(points, size);
  pcl::PointCloud<Point> turned = points;
  const Eigen::Matrix3f R_float = R.cast<float>();
  for (Point& point : turned) point.getVector3fMap() = R_float * point.getVector3fMap();
  labelByShape(turned, size);
  for (std::size_t i = 0; i < turned.size(); ++i) points[i].label = turned[i].label;
}

}  // namespace xview
