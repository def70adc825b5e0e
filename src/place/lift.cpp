// SPDX-License-Identifier: BSD-3-Clause
#include "place/lift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/cells.h"
#include "place/row_loops.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// A camera whose nearest tenth is farther away than this looks down from the air.
constexpr float kAerialQuantile_m = 15;

std::string sizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

[[noreturn]] void refuse(const Frame& frame, const std::string& what) {
  throw Error("frame " + std::to_string(frame.number), what);
}

template <class ImageType>
void checkSize(const Frame& frame, const ImageType& image, const char* name) {
  if (image.width == frame.depth.width && image.height == frame.depth.height) return;
  refuse(frame, std::string("expected the ") + name + " image to be as large as the depth image, " +
                    sizeText(frame.depth.width, frame.depth.height) + ", found " +
                    sizeText(image.width, image.height));
}

void checkImages(const Frame& frame) {
  checkSize(frame, frame.label, "label");
  if (!frame.instance.empty()) checkSize(frame, frame.instance, "instance");
  const Camera& camera = frame.camera;
  const bool positive = camera.fx > 0 && camera.fy > 0;
  if (!positive || !std::isfinite(camera.fx * camera.fy + camera.cx + camera.cy)) {
    refuse(frame, "expected positive, finite focal lengths, found fx " + std::to_string(camera.fx) +
                      ", fy " + std::to_string(camera.fy));
  }
}

Eigen::Vector3d roundedToMetre(const Eigen::Vector3d& p) { return p.array().round(); }

DepthCounts nearDepths(const DepthImage& depth) {
  return countDepths(depth.pixels.data(), depth.pixels.size(), 0, kAerialQuantile_m);
}

/// The options and the camera itself; the stricter one counts.
double maxCameraRange(const DepthCounts& near, const Camera& camera, const LiftOptions& options) {
  const bool is_aerial = near.measured > 0 && near.within * 10 < near.measured;
  return std::min(options.max_range_m * (is_aerial ? kRangeFromTheAir : 1), camera.max_range_m);
}

float squared(double range_m) { return static_cast<float>(range_m * range_m); }

/// From the sensor frame to points relative to a rounded origin, in single precision.
struct SensorToCloud {
  Eigen::Matrix3f R;
  Eigen::Vector3f shift;

  /// `start` is where the points are counted from, in the odometry frame.
  SensorToCloud(const Frame& frame, const Eigen::Vector3d& start, const Eigen::Vector3d& origin)
      : R(frame.T_odom_sensor.linear().cast<float>()), shift((start - origin).cast<float>()) {}
};

/// What is known of a frame before its points are looked at.
struct LiftPlan {
  float min_range2, max_range2;  ///< smallest and largest distance that is believed, squared
  Eigen::Vector3d origin;        ///< of the points, in the odometry frame
  std::size_t expected;          ///< points, at most
};

LiftPlan planOf(const Frame& frame, const LiftOptions& options) {
  if (!frame.T_odom_sensor.matrix().allFinite()) refuse(frame, "the pose is not finite");
  const Eigen::Vector3d sensor = frame.T_odom_sensor.translation();
  if (frame.sensor == Sensor::camera) {
    checkImages(frame);
    const DepthCounts near = nearDepths(frame.depth);
    return {squared(std::max(options.min_range_m, frame.camera.min_range_m)),
            squared(maxCameraRange(near, frame.camera, options)), roundedToMetre(sensor),
            near.measured};
  }
  const Eigen::Vector3d start = frame.T_odom_sensor * frame.cloud.origin;
  return {squared(options.min_range_m), squared(options.max_range_m * kRangeOfLidar),
          roundedToMetre(frame.sensor == Sensor::lidar ? sensor : start), frame.cloud.size()};
}

/// Counts measurements, those that do not count under the first reason.
class Gate {
 public:
  explicit Gate(const LabelSet& set) : set_(set) {}

  bool passes(std::uint32_t label, bool is_measured, bool is_in_range) {
    if (set_.role(label) == Role::ignored) {
      ++counts_.ignored_class;
      countUnknown(label);
    } else if (!is_measured) {
      ++counts_.no_depth;
    } else if (!is_in_range) {
      ++counts_.out_of_range;
    } else {
      ++counts_.lifted;
      return true;
    }
    return false;
  }

  const LiftCounts& counts() const { return counts_; }

 private:
  /// Of a label that does not count. Neighbours are mostly of one class.
  void countUnknown(std::uint32_t label) {
    if (!last_ignored_ || *last_ignored_ != label) {
      last_ignored_ = label;
      count_of_last_ = set_.find(label) ? nullptr : &counts_.unknown[label];
    }
    if (count_of_last_) ++*count_of_last_;
  }

  const LabelSet& set_;
  LiftCounts counts_;
  std::optional<std::uint32_t> last_ignored_;
  std::uint64_t* count_of_last_ = nullptr;  ///< null if the set knows it
};

RowOfRays raysOf(const Camera& camera, const SensorToCloud& to_cloud, const LiftPlan& plan, int v) {
  RowOfRays rays{};
  rays.first_x = static_cast<float>(-camera.cx / camera.fx);
  rays.step_x = static_cast<float>(1 / camera.fx);
  rays.y = static_cast<float>((v - camera.cy) / camera.fy);
  const Eigen::Vector3f towards = to_cloud.R.col(1) * rays.y + to_cloud.R.col(2);
  for (int k = 0; k < 3; ++k) {
    rays.towards[k] = towards[k];
    rays.across[k] = to_cloud.R(k, 0);
    rays.shift[k] = to_cloud.shift[k];
  }
  rays.depth_is_range = camera.depth_is_range;
  rays.min_range2 = plan.min_range2, rays.max_range2 = plan.max_range2;
  return rays;
}

template <class Take>
void liftImages(const Frame& frame, const LiftPlan& plan, Gate& gate, const Take& take) {
  const SensorToCloud to_cloud(frame, frame.T_odom_sensor.translation(), plan.origin);
  const auto width = static_cast<std::size_t>(frame.depth.width);
  std::vector<float> x(width), y(width), z(width), range(width);
  std::vector<std::uint8_t> state(width);
  for (int v = 0; v < frame.depth.height; ++v) {
    projectRow(raysOf(frame.camera, to_cloud, plan, v), &frame.depth.at(0, v), width, x.data(),
               y.data(), z.data(), range.data(), state.data());
    const std::uint16_t* label = &frame.label.at(0, v);
    const std::uint16_t* instance = frame.instance.empty() ? nullptr : &frame.instance.at(0, v);
    for (std::size_t u = 0; u < width; ++u) {
      if (!gate.passes(label[u], state[u] != kNoDepth, state[u] == kMeasured)) continue;
      Point point(x[u], y[u], z[u], label[u]);
      point.instance = instance ? instance[u] : 0;
      take(point, range[u]);
    }
  }
}

template <class Take>
void liftPoints(const Frame& frame, const LiftPlan& plan, Gate& gate, const Take& take) {
  const LabelledCloud& in = frame.cloud;
  const SensorToCloud to_cloud(frame, frame.T_odom_sensor * in.origin, plan.origin);
  const Eigen::Vector3f origin = in.origin.cast<float>();
  const bool is_scan = frame.sensor == Sensor::lidar;
  for (const Point& measured : in.points) {
    const Eigen::Vector3f p = measured.getVector3fMap();
    const float range2 = (p + origin).squaredNorm();
    const bool is_in_range = range2 >= plan.min_range2 && range2 <= plan.max_range2;
    if (!gate.passes(measured.label, p.allFinite(), !is_scan || is_in_range)) continue;
    const Eigen::Vector3f q = to_cloud.R * p + to_cloud.shift;
    Point point(q.x(), q.y(), q.z(), measured.label);
    point.instance = measured.instance;
    point.sigma = measured.sigma;
    take(point, is_scan ? std::sqrt(range2) : 0);
  }
}

/// Hands the points of a frame that count to take(point, range_m), one after the other, so that a
/// frame need never be held as points. The range of a point of a saved cloud is 0.
template <class Take>
LiftCounts forEachPoint(const Frame& frame, const LabelSet& set, const LiftPlan& plan,
                        const Take& take) {
  Gate gate(set);
  if (frame.sensor == Sensor::camera)
    liftImages(frame, plan, gate, take);
  else
    liftPoints(frame, plan, gate, take);
  return gate.counts();
}

/// Sums of the points of a voxel, relative to its first point so that they stay small.
struct Sums {
  ClassCell key;
  Eigen::Vector3f first;
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();
  float sigma = 0;
  std::uint32_t count = 0;

  void add(const Point& point) {
    offset += point.getVector3fMap() - first;
    sigma += point.sigma;
    ++count;
  }
  Point mean() const {
    const float weight = 1.0f / static_cast<float>(count);
    const Eigen::Vector3f p = first + offset * weight;
    Point point(p.x(), p.y(), p.z(), key.label);
    point.instance = key.instance;
    point.sigma = sigma * weight;
    return point;
  }
};

/// What thinByVoxel does, for points that come one by one.
class VoxelThinner {
 public:
  /// Points are relative to `origin`; `expected` of them, more or less.
  VoxelThinner(const Eigen::Vector3d& origin, double voxel_m, std::size_t expected)
      : origin_(origin), per_metre_(1 / voxel_m), start_(origin * per_metre_) {
    voxels_.reserve(expected / 8);  // few have one point only, and a small table stays in the cache
  }

  void add(const Point& point) {
    const Eigen::Vector3d p = point.getVector3fMap().cast<double>() * per_metre_ + start_;
    if (!(p.array().abs() < kFarthestCell).all()) return;
    const ClassCell voxel{floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z()), point.label,
                          point.instance};
    const auto make = [&] { return Sums{voxel, point.getVector3fMap()}; };
    voxels_[voxels_.numberOf(voxel, make)].add(point);
  }

  /// Adds a point per voxel to `thin`, and to `points_per_voxel`, if it is given, the number of
  /// points that it stands for.
  void appendTo(LabelledCloud& thin, std::vector<std::uint32_t>* points_per_voxel) const {
    if (thin.empty()) {
      thin.origin = origin_;
      thin.points.reserve(voxels_.size());
    }
    for (const Sums& voxel : voxels_.entries()) {
      thin.points.push_back(voxel.mean());
      if (points_per_voxel) points_per_voxel->push_back(voxel.count);
    }
  }

 private:
  Eigen::Vector3d origin_;
  double per_metre_;
  Eigen::Vector3d start_;   ///< the origin in voxels
  CellTable<Sums> voxels_;  ///< in order of first appearance
};

/// Numbers of points, square by square.
struct SquareOrder {
  std::vector<std::uint32_t> points;
  std::vector<std::size_t> ends;  ///< in `points`, of each square
};

/// Squares of 128 by 128 voxels, in order of first appearance. Points without a voxel are left out.
SquareOrder orderBySquare(const LabelledCloud& cloud, double voxel_m) {
  struct Square {
    PlaneCell key;
    std::size_t points = 0;
  };
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  const double per_metre = 1 / voxel_m;
  const Eigen::Vector2d start = cloud.origin.head<2>() * per_metre;
  CellTable<Square> squares;
  std::vector<std::uint32_t> square_of(cloud.size(), kNone);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector2d p =
        cloud.points[i].getVector3fMap().head<2>().cast<double>() * per_metre + start;
    if (!(p.array().abs() < kFarthestCell).all()) continue;
    const PlaneCell key{floorToInt(p.x()) >> 7, floorToInt(p.y()) >> 7};
    const std::size_t square = squares.numberOf(key, [&] { return Square{key}; });
    square_of[i] = static_cast<std::uint32_t>(square);
    ++squares[square].points;
  }
  SquareOrder order;
  std::size_t end = 0;
  for (const Square& square : squares.entries()) {
    order.ends.push_back(end);
    end += square.points;
  }
  order.points.resize(end);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (square_of[i] != kNone)
      order.points[order.ends[square_of[i]]++] = static_cast<std::uint32_t>(i);
  }
  return order;
}

}  // namespace

LiftCounts& LiftCounts::operator+=(const LiftCounts& other) {
  lifted += other.lifted;
  no_depth += other.no_depth;
  out_of_range += other.out_of_range;
  ignored_class += other.ignored_class;
  for (const auto& [id, count] : other.unknown) unknown[id] += count;
  return *this;
}

double maxRange(const Frame& frame, const LiftOptions& options) {
  if (frame.sensor == Sensor::cloud) return std::numeric_limits<double>::infinity();
  if (frame.sensor == Sensor::lidar) return options.max_range_m * kRangeOfLidar;
  return maxCameraRange(nearDepths(frame.depth), frame.camera, options);
}

LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts) {
  const LiftPlan plan = planOf(frame, options);
  LabelledCloud cloud;
  cloud.origin = plan.origin;
  cloud.points.reserve(plan.expected);
  const LiftCounts found = forEachPoint(
      frame, set, plan, [&](const Point& point, float) { cloud.points.push_back(point); });
  if (counts) *counts = found;
  return cloud;
}

LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel) {
  if (voxel_m <= 0) {
    if (points_per_voxel) points_per_voxel->assign(cloud.size(), 1);
    return cloud;
  }
  constexpr std::size_t kFewPoints = 200000;  // their voxels stay in the cache
  LabelledCloud thin;
  thin.origin = cloud.origin;
  if (points_per_voxel) points_per_voxel->clear();
  if (cloud.size() <= kFewPoints) {
    VoxelThinner thinner(cloud.origin, voxel_m, cloud.size());
    for (const Point& point : cloud.points) thinner.add(point);
    thinner.appendTo(thin, points_per_voxel);
    return thin;
  }
  thin.points.reserve(cloud.size());  // only what is filled costs memory
  const SquareOrder order = orderBySquare(cloud, voxel_m);
  std::size_t i = 0;
  for (const std::size_t end : order.ends) {
    VoxelThinner thinner(cloud.origin, voxel_m, end - i);
    for (; i < end; ++i) thinner.add(cloud.points[order.points[i]]);
    thinner.appendTo(thin, points_per_voxel);
  }
  return thin;
}

ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts) {
  const LiftPlan plan = planOf(frame, options);
  ThinFrame result;
  result.whole.origin = plan.origin;
  VoxelThinner thinner(plan.origin, voxel_m, plan.expected);
  std::size_t near = 0;  // points not farther than kAerialQuantile_m
  const LiftCounts found = forEachPoint(frame, set, plan, [&](const Point& point, float range_m) {
    thinner.add(point);
    near += range_m <= kAerialQuantile_m;
    if (whole == WholeClasses::all ||
        (whole == WholeClasses::no_surfaces && set.role(point.label) != Role::surface))
      result.whole.points.push_back(point);
  });
  thinner.appendTo(result.thin, &result.points_per_voxel);
  result.is_aerial = frame.sensor == Sensor::camera && found.lifted > 0 && 10 * near < found.lifted;
  if (counts) *counts = found;
  return result;
}

}  // namespace xview
