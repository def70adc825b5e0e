// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/lift.h"

#include <cmath>
#include <string>
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

void finish(LabelledCloud& cloud) {
  cloud.points.width = static_cast<std::uint32_t>(cloud.points.points.size());
  cloud.points.height = 1;
  cloud.points.is_dense = true;
}

LabelledCloud liftImages(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                         LiftCounts& counts) {
  checkImages(frame);
  const DepthCounts depths = countDepths(frame.depth);
  const bool is_aerial = depths.valid > 0 && depths.near * 10 < depths.valid;
  const Gate gate(options.min_range_m,
                  is_aerial ? options.max_range_aerial_m : options.max_range_m);
  const KnownClasses known(set);
  const Camera& camera = frame.camera;

  LabelledCloud cloud;
  cloud.origin = roundedToMetre(frame.T_odom_sensor.translation());
  cloud.points.points.reserve(depths.valid);
  cloud.ranges.reserve(depths.valid);
  if (!frame.instance.empty()) cloud.instances.reserve(depths.valid);

  // p_odom - origin = z * (R * [x y 1]) + shift, with x and y the normalised image coordinates
  const Eigen::Matrix3f R = frame.T_odom_sensor.linear().cast<float>();
  const Eigen::Vector3f shift = (frame.T_odom_sensor.translation() - cloud.origin).cast<float>();
  for (int v = 0; v < frame.depth.height; ++v) {
    const float y = static_cast<float>((v - camera.cy) / camera.fy);
    const Eigen::Vector3f row = R.col(1) * y + R.col(2);
    const float inverse_fx = static_cast<float>(1 / camera.fx);
    const float first_x = static_cast<float>(-camera.cx / camera.fx);
    for (int u = 0; u < frame.depth.width; ++u) {
      const std::uint16_t label = frame.label.at(u, v);
      if (!known(label)) {
        ++counts.ignored_class;
        continue;
      }
      float z = frame.depth.at(u, v);
      if (!isDepth(z)) {
        ++counts.no_depth;
        continue;
      }
      const float x = first_x + static_cast<float>(u) * inverse_fx;
      const float ray2 = x * x + y * y + 1;
      if (camera.depth_is_range) z /= std::sqrt(ray2);
      const float range2 = z * z * ray2;
      if (!gate.holds(range2)) {
        ++counts.out_of_range;
        continue;
      }
      const Eigen::Vector3f p = (row + R.col(0) * x) * z + shift;
      cloud.points.points.emplace_back(p.x(), p.y(), p.z(), label);
      cloud.ranges.push_back(std::sqrt(range2));
      if (!frame.instance.empty()) cloud.instances.push_back(frame.instance.at(u, v));
    }
  }
  return cloud;
}

LabelledCloud liftCloud(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                        LiftCounts& counts) {
  const LabelledCloud& in = frame.cloud;
  const bool is_scan = frame.sensor == Sensor::lidar;
  const Gate gate(options.min_range_m, options.max_range_lidar_m);
  const KnownClasses known(set);
  const bool keeps_ranges = !is_scan && in.ranges.size() == in.size();
  const bool has_instances = in.instances.size() == in.size();

  LabelledCloud cloud;
  const Eigen::Vector3d start = frame.T_odom_sensor * in.origin;
  cloud.origin =
      roundedToMetre(is_scan ? Eigen::Vector3d(frame.T_odom_sensor.translation()) : start);
  cloud.points.points.reserve(in.size());
  if (is_scan || keeps_ranges) cloud.ranges.reserve(in.size());
  if (has_instances) cloud.instances.reserve(in.size());

  const Eigen::Matrix3f R = frame.T_odom_sensor.linear().cast<float>();
  const Eigen::Vector3f shift = (start - cloud.origin).cast<float>();
  const Eigen::Vector3f sensor_to_origin = in.origin.cast<float>();
  for (std::size_t i = 0; i < in.size(); ++i) {
    const pcl::PointXYZL& point = in.points.points[i];
    if (!known(point.label)) {
      ++counts.ignored_class;
      continue;
    }
    const Eigen::Vector3f p_cloud = point.getVector3fMap();
    if (!p_cloud.allFinite()) {
      ++counts.no_depth;
      continue;
    }
    const float range2 = (p_cloud + sensor_to_origin).squaredNorm();
    if (is_scan && !gate.holds(range2)) {
      ++counts.out_of_range;
      continue;
    }
    const Eigen::Vector3f p = R * p_cloud + shift;
    cloud.points.points.emplace_back(p.x(), p.y(), p.z(), point.label);
    if (is_scan) cloud.ranges.push_back(std::sqrt(range2));
    if (keeps_ranges) cloud.ranges.push_back(in.ranges[i]);
    if (has_instances) cloud.instances.push_back(in.instances[i]);
  }
  return cloud;
}

}  // namespace

LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts) {
  checkPose(frame);
  LiftCounts local;
  LabelledCloud cloud = frame.sensor == Sensor::camera ? liftImages(frame, set, options, local)
                                                       : liftCloud(frame, set, options, local);
  finish(cloud);
  local.lifted = cloud.size();
  if (counts) *counts = local;
  return cloud;
}

}  // namespace xview
