// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/lift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "xview/types/error.h"

namespace xview {
namespace {

// A camera whose nearest tenth is further away than this looks down from the air.
constexpr float kAerialQuantile_m = 15;

/// Which class ids carry information, as a table because it is asked once per pixel.
class KnownClasses {
 public:
  explicit KnownClasses(const LabelSet& set) : set_(set), table_(1 << 16, 0) {
    for (const auto& [id, info] : set.classes()) {
      if (id < table_.size()) table_[id] = info.role != Role::ignored;
    }
  }
  bool operator()(std::uint32_t id) const {
    return id < table_.size() ? table_[id] != 0 : set_.role(id) != Role::ignored;
  }

 private:
  const LabelSet& set_;
  std::vector<std::uint8_t> table_;
};

std::string sizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void checkPose(const Frame& frame) {
  if (!frame.T_odom_sensor.matrix().allFinite()) {
    throw Error("frame " + std::to_string(frame.number), "the pose is not finite");
  }
}

template <class ImageType>
void checkSize(const Frame& frame, const ImageType& image, const char* name) {
  if (image.width == frame.depth.width && image.height == frame.depth.height) return;
  throw Error("frame " + std::to_string(frame.number),
              std::string("expected the ") + name + " image to be as large as the depth image, " +
                  sizeText(frame.depth.width, frame.depth.height) + ", found " +
                  sizeText(image.width, image.height));
}

void checkImages(const Frame& frame) {
  checkSize(frame, frame.label, "label");
  if (!frame.instance.empty()) checkSize(frame, frame.instance, "instance");
  const Camera& camera = frame.camera;
  const bool positive = camera.fx > 0 && camera.fy > 0;
  if (!positive || !std::isfinite(camera.fx * camera.fy + camera.cx + camera.cy)) {
    throw Error("frame " + std::to_string(frame.number),
                "expected positive, finite focal lengths, found fx " + std::to_string(camera.fx) +
                    ", fy " + std::to_string(camera.fy));
  }
}

/// Finite and positive; false for NaN.
bool isDepth(float z) { return z > 0 && z < 1e9f; }

struct DepthCounts {
  std::size_t valid = 0;
  std::size_t near = 0;  ///< of these, not further than kAerialQuantile_m
};

DepthCounts countDepths(const DepthImage& depth) {
  std::uint32_t valid = 0, near = 0;
  for (const float z : depth.pixels) {
    const bool ok = isDepth(z);
    valid += ok;
    near += ok & (z <= kAerialQuantile_m);
  }
  return {valid, near};
}

/// Smallest and largest distance that is believed, squared.
struct Gate {
  float min2, max2;
  Gate(double min_m, double max_m)
      : min2(static_cast<float>(min_m * min_m)), max2(static_cast<float>(max_m * max_m)) {}
  bool holds(float range2) const { return range2 >= min2 && range2 <= max2; }
};

Eigen::Vector3d roundedToMetre(const Eigen::Vector3d& p) { return p.array().round(); }

/// From the sensor frame to points relative to a rounded origin, in single precision.
struct SensorToCloud {
  Eigen::Matrix3f R;
  Eigen::Vector3f shift;

  /// `start` is where the points are counted from, in the odometry frame.
  SensorToCloud(const Frame& frame, const Eigen::Vector3d& start, const Eigen::Vector3d& origin)
      : R(frame.T_odom_sensor.linear().cast<float>()), shift((start - origin).cast<float>()) {}
};

/// Collects what passes the gates, and counts what does not.
class Lifting {
 public:
  Lifting(const LabelSet& set, const Gate& gate, const Eigen::Vector3d& origin,
          std::size_t capacity)
      : known_(set), gate_(gate) {
    cloud_.origin = origin;
    cloud_.points.points.reserve(capacity);
    cloud_.ranges.reserve(capacity);
  }

  void liftImages(const Frame& frame) {
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor.translation(), cloud_.origin);
    for (int v = 0; v < frame.depth.height; ++v) liftRow(frame, to_cloud, v);
  }

  void liftPoints(const Frame& frame) {
    const LabelledCloud& in = frame.cloud;
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor * in.origin, cloud_.origin);
    const Eigen::Vector3f origin = in.origin.cast<float>();
    const bool is_scan = frame.sensor == Sensor::lidar;
    const bool has_ranges = is_scan || in.ranges.size() == in.size();
    const bool has_instances = in.instances.size() == in.size();
    for (std::size_t i = 0; i < in.size(); ++i) {
      const pcl::PointXYZL& point = in.points.points[i];
      const Eigen::Vector3f p = point.getVector3fMap();
      if (!holdsInformation(point.label) || !isMeasured(p.allFinite())) continue;
      const float range2 = (p + origin).squaredNorm();
      if (is_scan && !isInRange(range2)) continue;
      push(to_cloud.R * p + to_cloud.shift, point.label);
      if (has_ranges) cloud_.ranges.push_back(is_scan ? std::sqrt(range2) : in.ranges[i]);
      if (has_instances) cloud_.instances.push_back(in.instances[i]);
    }
  }

  LabelledCloud finish(LiftCounts* counts) {
    cloud_.points.width = static_cast<std::uint32_t>(cloud_.points.points.size());
    cloud_.points.height = 1;
    cloud_.points.is_dense = true;
    counts_.lifted = cloud_.size();
    if (counts) *counts = counts_;
    return std::move(cloud_);
  }

 private:
  // p_cloud = z * R * [x y 1] + shift, with x and y the normalised image coordinates
  void liftRow(const Frame& frame, const SensorToCloud& to_cloud, int v) {
    const Camera& camera = frame.camera;
    const float y = static_cast<float>((v - camera.cy) / camera.fy);
    const float first_x = static_cast<float>(-camera.cx / camera.fx);
    const float step_x = static_cast<float>(1 / camera.fx);
    const Eigen::Vector3f row = to_cloud.R.col(1) * y + to_cloud.R.col(2);
    row_points_.clear();
    row_ranges_.clear();
    for (int u = 0; u < frame.depth.width; ++u) {
      const std::uint16_t label = frame.label.at(u, v);
      float z = frame.depth.at(u, v);
      if (!holdsInformation(label) || !isMeasured(isDepth(z))) continue;
      const float x = first_x + static_cast<float>(u) * step_x;
      const float ray2 = x * x + y * y + 1;
      if (camera.depth_is_range) z /= std::sqrt(ray2);
      const float range2 = z * z * ray2;
      if (!isInRange(range2)) continue;
      const Eigen::Vector3f p = (row + to_cloud.R.col(0) * x) * z + to_cloud.shift;
      row_points_.emplace_back(p.x(), p.y(), p.z(), label);
      row_ranges_.push_back(std::sqrt(range2));
      if (!frame.instance.empty()) cloud_.instances.push_back(frame.instance.at(u, v));
    }
    auto& points = cloud_.points.points;
    points.insert(points.end(), row_points_.begin(), row_points_.end());
    cloud_.ranges.insert(cloud_.ranges.end(), row_ranges_.begin(), row_ranges_.end());
  }

  bool holdsInformation(std::uint32_t label) {
    const bool ok = known_(label);
    counts_.ignored_class += !ok;
    return ok;
  }
  bool isMeasured(bool ok) {
    counts_.no_depth += !ok;
    return ok;
  }
  bool isInRange(float range2) {
    const bool ok = gate_.holds(range2);
    counts_.out_of_range += !ok;
    return ok;
  }
  void push(const Eigen::Vector3f& p, std::uint32_t label) {
    cloud_.points.points.emplace_back(p.x(), p.y(), p.z(), label);
  }

  KnownClasses known_;
  Gate gate_;
  LabelledCloud cloud_;
  LiftCounts counts_;
  std::vector<pcl::PointXYZL> row_points_;  ///< of one image row, as it stays in the cache
  std::vector<float> row_ranges_;
};

/// The options and the camera itself; the stricter one counts.
double maxCameraRange(const DepthCounts& depths, const Camera& camera, const LiftOptions& options) {
  const bool is_aerial = depths.valid > 0 && depths.near * 10 < depths.valid;
  return std::min(is_aerial ? options.max_range_aerial_m : options.max_range_m, camera.max_range_m);
}

}  // namespace

double maxRange(const Frame& frame, const LiftOptions& options) {
  if (frame.sensor == Sensor::cloud) return std::numeric_limits<double>::infinity();
  if (frame.sensor == Sensor::lidar) return options.max_range_lidar_m;
  return maxCameraRange(countDepths(frame.depth), frame.camera, options);
}

LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts) {
  checkPose(frame);
  const Eigen::Vector3d sensor = frame.T_odom_sensor.translation();
  if (frame.sensor == Sensor::camera) {
    checkImages(frame);
    const DepthCounts depths = countDepths(frame.depth);
    const Gate gate(std::max(options.min_range_m, frame.camera.min_range_m),
                    maxCameraRange(depths, frame.camera, options));
    Lifting lifting(set, gate, roundedToMetre(sensor), depths.valid);
    lifting.liftImages(frame);
    return lifting.finish(counts);
  }
  const bool is_scan = frame.sensor == Sensor::lidar;
  const Eigen::Vector3d start = frame.T_odom_sensor * frame.cloud.origin;
  const Gate gate(options.min_range_m, options.max_range_lidar_m);
  Lifting lifting(set, gate, roundedToMetre(is_scan ? sensor : start), frame.cloud.size());
  lifting.liftPoints(frame);
  return lifting.finish(counts);
}

}  // namespace xview
