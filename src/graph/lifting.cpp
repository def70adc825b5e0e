// SPDX-License-Identifier: BSD-3-Clause
#include "lifting.h"

#include <cmath>
#include <vector>

#include "row_loops.h"

namespace xview {
namespace {

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
    PointRow row(kPointsAtOnce);
    for (std::size_t i = 0; i < in.size(); ++i) {
      const Point& point = in.points.points[i];
      const Eigen::Vector3f p = point.getVector3fMap();
      if (!holdsInformation(point.label) || !isMeasured(p.allFinite())) continue;
      const float range2 = (p + origin).squaredNorm();
      if (is_scan && !isInRange(range2)) continue;
      const Eigen::Vector3f q = to_cloud.R * p + to_cloud.shift;
      row.x[row.size] = q.x(), row.y[row.size] = q.y(), row.z[row.size] = q.z();
      row.label[row.size] = point.label;
      row.range[row.size] = is_scan ? std::sqrt(range2) : 0;
      row.instance[row.size] = point.instance;
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

}  // namespace

LiftCounts liftInto(PointSink& sink, const LiftPlan& plan, const Frame& frame,
                    const LabelSet& set) {
  Lifting lifting(set, plan.gate, plan.origin, sink);
  if (frame.sensor == Sensor::camera)
    lifting.liftImages(frame);
  else
    lifting.liftPoints(frame);
  return lifting.counts();
}

}  // namespace xview
