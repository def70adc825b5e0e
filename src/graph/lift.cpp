// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/lift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "point_row.h"
#include "row_loops.h"
#include "voxel_thinner.h"
#include "xview/graph/thin_frame.h"
#include "xview/types/error.h"

namespace xview {
namespace {

// A camera whose nearest tenth is further away than this looks down from the air.
constexpr float kAerialQuantile_m = 15;
constexpr std::size_t kPointsAtOnce = 512;  ///< stay in the first cache

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

/// Takes lifted points, row by row.
class PointSink {
 public:
  virtual ~PointSink() = default;
  virtual void add(const PointRow& row) = 0;
};

/// Hands on what passes the gates, and counts what does not.
class Lifting {
 public:
  Lifting(const LabelSet& set, const Gate& gate, const Eigen::Vector3d& origin, PointSink& sink)
      : known_(set), gate_(gate), origin_(origin), sink_(sink) {}

  void liftImages(const Frame& frame) {
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor.translation(), origin_);
    const auto width = static_cast<std::size_t>(frame.depth.width);
    PointRow row(width);
    std::vector<std::uint8_t> state(width);
    for (int v = 0; v < frame.depth.height; ++v) {
      projectRow(raysOf(frame.camera, to_cloud, v), &frame.depth.at(0, v), width, row.x.data(),
                 row.y.data(), row.z.data(), row.range.data(), state.data());
      keepMeasured(frame, v, state, row);
      sink_.add(row);
    }
  }

  void liftPoints(const Frame& frame) {
    const LabelledCloud& in = frame.cloud;
    const SensorToCloud to_cloud(frame, frame.T_odom_sensor * in.origin, origin_);
    const Eigen::Vector3f origin = in.origin.cast<float>();
    const bool is_scan = frame.sensor == Sensor::lidar;
    const bool has_ranges = in.ranges.size() == in.size();
    const bool has_instances = in.instances.size() == in.size();
    PointRow row(kPointsAtOnce);
    for (std::size_t i = 0; i < in.size(); ++i) {
      const pcl::PointXYZL& point = in.points.points[i];
      const Eigen::Vector3f p = point.getVector3fMap();
      if (!holdsInformation(point.label) || !isMeasured(p.allFinite())) continue;
      const float range2 = (p + origin).squaredNorm();
      if (is_scan && !isInRange(range2)) continue;
      const Eigen::Vector3f q = to_cloud.R * p + to_cloud.shift;
      row.x[row.size] = q.x(), row.y[row.size] = q.y(), row.z[row.size] = q.z();
      row.label[row.size] = point.label;
      row.range[row.size] = is_scan ? std::sqrt(range2) : has_ranges ? in.ranges[i] : 0;
      row.instance[row.size] = has_instances ? in.instances[i] : 0;
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
    rays.min_range2 = gate_.min2, rays.max_range2 = gate_.max2;
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
      const std::size_t is_known = known_(label[u]);
      known += is_known;
      measured += is_known & static_cast<std::size_t>(state[u] != kNoDepth);
      kept += is_known & static_cast<std::size_t>(state[u] == kMeasured);
    }
    row.size = kept;
    counts_.ignored_class += state.size() - known;
    counts_.no_depth += known - measured;
    counts_.out_of_range += measured - kept;
    counts_.lifted += kept;
  }

  void flush(PointRow& row) {
    counts_.lifted += row.size;
    sink_.add(row);
    row.size = 0;
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

  KnownClasses known_;
  Gate gate_;
  Eigen::Vector3d origin_;
  PointSink& sink_;
  LiftCounts counts_;
};

/// Which columns the points of a frame have besides place and label.
struct Columns {
  bool instances, ranges;
  explicit Columns(const Frame& frame)
      : instances(frame.sensor == Sensor::camera
                      ? !frame.instance.empty()
                      : frame.cloud.instances.size() == frame.cloud.size()),
        ranges(frame.sensor != Sensor::cloud || frame.cloud.ranges.size() == frame.cloud.size()) {}
};

/// A cloud that grows row by row.
class GrowingCloud : public PointSink {
 public:
  GrowingCloud(const Columns& columns, const Eigen::Vector3d& origin) : columns_(columns) {
    cloud_.origin = origin;
  }

  void reserve(std::size_t points) {
    cloud_.points.points.reserve(points);
    if (columns_.instances) cloud_.instances.reserve(points);
    if (columns_.ranges) cloud_.ranges.reserve(points);
  }
  void add(const PointRow& row) override {
    const std::size_t first = cloud_.size();
    cloud_.points.points.resize(first + row.size);
    for (std::size_t i = 0; i < row.size; ++i)
      cloud_.points.points[first + i] = {row.x[i], row.y[i], row.z[i], row.label[i]};
    const auto end = static_cast<std::ptrdiff_t>(row.size);
    if (columns_.instances)
      cloud_.instances.insert(cloud_.instances.end(), row.instance.begin(),
                              row.instance.begin() + end);
    if (columns_.ranges)
      cloud_.ranges.insert(cloud_.ranges.end(), row.range.begin(), row.range.begin() + end);
  }
  void addPoint(const PointRow& row, std::size_t i) {
    cloud_.points.points.emplace_back(row.x[i], row.y[i], row.z[i], row.label[i]);
    if (columns_.instances) cloud_.instances.push_back(row.instance[i]);
    if (columns_.ranges) cloud_.ranges.push_back(row.range[i]);
  }
  LabelledCloud finish() {
    cloud_.points.width = static_cast<std::uint32_t>(cloud_.points.points.size());
    cloud_.points.height = 1;
    cloud_.points.is_dense = true;
    return std::move(cloud_);
  }

 private:
  Columns columns_;
  LabelledCloud cloud_;
};

/// Thins all points, and keeps those of some classes as they are.
class ThinningSink : public PointSink {
 public:
  ThinningSink(const Columns& columns, const Eigen::Vector3d& origin, double voxel_m,
               std::size_t expected, const LabelSet& set, WholeClasses whole)
      : columns_(columns),
        thinner_(origin, voxel_m, expected),
        whole_(columns, origin),
        set_(set),
        which_(whole) {}

  void add(const PointRow& row) override {
    thinner_.add(row);
    if (which_ == WholeClasses::all) whole_.add(row);
    if (which_ == WholeClasses::no_surfaces) addWithoutSurfaces(row);
    for (std::size_t i = 0; i < row.size; ++i) near_ += row.range[i] <= kAerialQuantile_m;
  }
  ThinFrame finish() {
    ThinFrame frame;
    frame.thin = thinner_.finish(columns_.instances, columns_.ranges, &frame.points_per_voxel);
    frame.whole = whole_.finish();
    return frame;
  }
  std::size_t near() const { return near_; }

 private:
  void addWithoutSurfaces(const PointRow& row) {
    for (std::size_t i = 0; i < row.size; ++i) {
      if (row.label[i] != last_label_) {
        last_label_ = row.label[i];
        is_surface_ = set_.role(last_label_) == Role::surface;
      }
      if (!is_surface_) whole_.addPoint(row, i);
    }
  }

  Columns columns_;
  VoxelThinner thinner_;
  GrowingCloud whole_;
  const LabelSet& set_;
  WholeClasses which_;
  std::size_t near_ = 0;  ///< points not further than kAerialQuantile_m
  std::uint32_t last_label_ = 0;
  bool is_surface_ = set_.role(0) == Role::surface;
};

/// The options and the camera itself; the stricter one counts.
double maxCameraRange(const DepthCounts& depths, const Camera& camera, const LiftOptions& options) {
  const bool is_aerial = depths.measured > 0 && depths.within * 10 < depths.measured;
  return std::min(is_aerial ? options.max_range_aerial_m : options.max_range_m, camera.max_range_m);
}

DepthCounts nearDepths(const DepthImage& depth) {
  return countDepths(depth.pixels.data(), depth.pixels.size(), 0, kAerialQuantile_m);
}

/// What is known of a frame before its points are looked at.
struct Plan {
  Gate gate;
  Eigen::Vector3d origin;
  std::size_t expected;  ///< points, at most
};

Plan planOf(const Frame& frame, const LiftOptions& options) {
  checkPose(frame);
  const Eigen::Vector3d sensor = frame.T_odom_sensor.translation();
  if (frame.sensor == Sensor::camera) {
    checkImages(frame);
    const DepthCounts depths = nearDepths(frame.depth);
    return {{std::max(options.min_range_m, frame.camera.min_range_m),
             maxCameraRange(depths, frame.camera, options)},
            roundedToMetre(sensor),
            depths.measured};
  }
  const Eigen::Vector3d start = frame.T_odom_sensor * frame.cloud.origin;
  return {{options.min_range_m, options.max_range_lidar_m},
          roundedToMetre(frame.sensor == Sensor::lidar ? sensor : start),
          frame.cloud.size()};
}

LiftCounts liftInto(PointSink& sink, const Plan& plan, const Frame& frame, const LabelSet& set) {
  Lifting lifting(set, plan.gate, plan.origin, sink);
  if (frame.sensor == Sensor::camera)
    lifting.liftImages(frame);
  else
    lifting.liftPoints(frame);
  return lifting.counts();
}

}  // namespace

double maxRange(const Frame& frame, const LiftOptions& options) {
  if (frame.sensor == Sensor::cloud) return std::numeric_limits<double>::infinity();
  if (frame.sensor == Sensor::lidar) return options.max_range_lidar_m;
  return maxCameraRange(nearDepths(frame.depth), frame.camera, options);
}

LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts) {
  const Plan plan = planOf(frame, options);
  GrowingCloud cloud(Columns(frame), plan.origin);
  cloud.reserve(plan.expected);
  const LiftCounts found = liftInto(cloud, plan, frame, set);
  if (counts) *counts = found;
  return cloud.finish();
}

ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts) {
  const Plan plan = planOf(frame, options);
  ThinningSink sink(Columns(frame), plan.origin, voxel_m, plan.expected, set, whole);
  const LiftCounts found = liftInto(sink, plan, frame, set);
  ThinFrame result = sink.finish();
  result.is_aerial =
      frame.sensor == Sensor::camera && found.lifted > 0 && 10 * sink.near() < found.lifted;
  if (counts) *counts = found;
  return result;
}

}  // namespace xview
