// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/lift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "graph/point_rows.h"
#include "xview/types/error.h"

namespace xview::graph {
namespace {

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

/// Hands on what passes the gates, and counts what does not.
class Lifting {
 public:
  Lifting(const LabelSet& set, const LiftPlan& plan,
          const std::function<void(const PointRow&)>& take)
      : set_(set), plan_(plan), take_(take) {}

  void liftImages(const Frame& frame) {
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor.translation(), plan_.origin);
    const auto width = static_cast<std::size_t>(frame.depth.width);
    PointRow row(width);
    std::vector<std::uint8_t> state(width);
    for (int v = 0; v < frame.depth.height; ++v) {
      projectRow(raysOf(frame.camera, to_cloud, v), &frame.depth.at(0, v), width, row.x.data(),
                 row.y.data(), row.z.data(), row.range.data(), state.data());
      keepMeasured(frame, v, state, row);
      take_(row);
    }
  }

  void liftPoints(const Frame& frame) {
    const LabelledCloud& in = frame.cloud;
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor * in.origin, plan_.origin);
    const Eigen::Vector3f origin = in.origin.cast<float>();
    const bool is_scan = frame.sensor == Sensor::lidar;
    PointRow row(kPointsAtOnce);
    for (const Point& point : in.points) {
      const Eigen::Vector3f p = point.getVector3fMap();
      const float range2 = (p + origin).squaredNorm();
      if (!counts(point.label, p.allFinite(), !is_scan || isInRange(range2))) continue;
      const Eigen::Vector3f q = to_cloud.R * p + to_cloud.shift;
      row.x[row.size] = q.x(), row.y[row.size] = q.y(), row.z[row.size] = q.z();
      row.label[row.size] = point.label;
      row.range[row.size] = is_scan ? std::sqrt(range2) : 0;
      row.instance[row.size] = point.instance;
      row.sigma[row.size] = point.sigma;
      if (++row.size == kPointsAtOnce) flush(row);
    }
    flush(row);
  }

  const LiftCounts& counts() const { return counts_; }

 private:
  RowOfRays raysOf(const Camera& camera, const SensorToCloud& to_cloud, int v) const {
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
    rays.min_range2 = plan_.min_range2, rays.max_range2 = plan_.max_range2;
    return rays;
  }

  /// Moves the points that count to the front of the row, without a branch for each pixel.
  void keepMeasured(const Frame& frame, int v, const std::vector<std::uint8_t>& state,
                    PointRow& row) {
    const std::uint16_t* label = &frame.label.at(0, v);
    const std::uint16_t* instance = frame.instance.empty() ? nullptr : &frame.instance.at(0, v);
    std::size_t kept = 0, known = 0, measured = 0;
    for (std::size_t u = 0; u < state.size(); ++u) {
      row.x[kept] = row.x[u], row.y[kept] = row.y[u], row.z[kept] = row.z[u];
      row.range[kept] = row.range[u];
      row.label[kept] = label[u];
      row.instance[kept] = instance ? instance[u] : 0;
      const std::size_t is_known = isKnown(label[u]);
      known += is_known;
      measured += is_known & static_cast<std::size_t>(state[u] != kNoDepth);
      kept += is_known & static_cast<std::size_t>(state[u] == kMeasured);
    }
    row.size = kept;
    counts_.ignored_class += state.size() - known;
    for (std::size_t u = 0; known < state.size() && u < state.size(); ++u) {
      if (!isKnown(label[u])) countUnknown(label[u]);
    }
    counts_.no_depth += known - measured;
    counts_.out_of_range += measured - kept;
    counts_.lifted += kept;
  }

  bool isKnown(std::uint32_t label) const { return set_.role(label) != Role::ignored; }
  /// Of a label that does not count. Neighbours are mostly of one class.
  void countUnknown(std::uint32_t label) {
    if (!last_ignored_ || *last_ignored_ != label) {
      last_ignored_ = label;
      count_of_last_ = set_.find(label) ? nullptr : &counts_.unknown[label];
    }
    if (count_of_last_) ++*count_of_last_;
  }
  bool isInRange(float range2) const {
    return range2 >= plan_.min_range2 && range2 <= plan_.max_range2;
  }

  /// Whether a point of a cloud counts; if not, it is counted under the first reason.
  bool counts(std::uint32_t label, bool is_measured, bool is_in_range) {
    if (!isKnown(label)) {
      ++counts_.ignored_class;
      countUnknown(label);
    } else if (!is_measured) {
      ++counts_.no_depth;
    } else if (!is_in_range) {
      ++counts_.out_of_range;
    } else {
      return true;
    }
    return false;
  }

  void flush(PointRow& row) {
    counts_.lifted += row.size;
    take_(row);
    row.size = 0;
  }

  const LabelSet& set_;
  const LiftPlan& plan_;
  const std::function<void(const PointRow&)>& take_;
  LiftCounts counts_;
  std::optional<std::uint32_t> last_ignored_;
  std::uint64_t* count_of_last_ = nullptr;  ///< null if the set knows it
};

}  // namespace

LiftCounts& LiftCounts::operator+=(const LiftCounts& other) {
  lifted += other.lifted;
  no_depth += other.no_depth;
  out_of_range += other.out_of_range;
  ignored_class += other.ignored_class;
  for (const auto& [id, count] : other.unknown) unknown[id] += count;
  return *this;
}

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

LiftCounts liftRows(const Frame& frame, const LabelSet& set, const LiftPlan& plan,
                    const std::function<void(const PointRow&)>& take) {
  Lifting lifting(set, plan, take);
  if (frame.sensor == Sensor::camera)
    lifting.liftImages(frame);
  else
    lifting.liftPoints(frame);
  return lifting.counts();
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
  const LiftCounts found = liftRows(frame, set, plan, [&](const PointRow& row) {
    for (std::size_t i = 0; i < row.size; ++i) cloud.points.push_back(row.point(i));
  });
  if (counts) *counts = found;
  return cloud;
}

}  // namespace xview::graph
