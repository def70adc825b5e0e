// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "xview/base/frame.h"

namespace xview {

/// True for point types with a field `label`: pcl::PointXYZL, pcl::PointXYZRGBL, own ones.
template <class PointT, class = void>
struct HasLabel : std::false_type {};
template <class PointT>
struct HasLabel<PointT, std::void_t<decltype(std::declval<const PointT&>().label)>>
    : std::true_type {};

/// The finite points of a cloud of PCL, with their field `label` if they have one; a negative label
/// is 0. `sensor_origin_` and `sensor_orientation_` are not applied, as PCL does not apply them. A
/// cloud of xview::Point keeps all its fields.
template <class PointT>
LabelledCloud toLabelledCloud(const pcl::PointCloud<PointT>& cloud) {
  LabelledCloud result;
  result.points.reserve(cloud.size());
  for (const PointT& p : cloud) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    if constexpr (std::is_same_v<PointT, Point>) {
      result.points.push_back(p);
    } else if constexpr (HasLabel<PointT>::value) {
      const auto label = static_cast<std::int64_t>(p.label);
      result.points.push_back(
          Point(p.x, p.y, p.z, static_cast<std::uint32_t>(label < 0 ? 0 : label)));
    } else {
      result.points.push_back(Point(p.x, p.y, p.z));
    }
  }
  return result;
}

/// Clouds in memory as a recording: scans of a driver with their poses, or one cloud that has no
/// view-point. Not to be read while clouds are added.
///
///     xview::CloudRecording scans;                 // raw: classes come from shapes
///     scans.add(cloud, T_odom_sensor, stamp_s);    // for every scan, in order
///     const xview::Localization fix = localizer.localize(scans);
class CloudRecording final : public FrameSource {
 public:
  /// `labels`: what the field `label` of the clouds means. Without it the clouds are raw, whatever
  /// labels they have: maps and queries give them classes from the shapes of their points, for
  /// which z is to be up. `name`: what messages call the recording.
  explicit CloudRecording(LabelSet labels = {}, std::string name = "clouds");

  /// A cloud without a view-point, as a file or a map has it: p_odom = p [m].
  /// Throws UsageError if there is a label set and the points have no field `label`.
  template <class PointT>
  void add(const pcl::PointCloud<PointT>& cloud) {
    requireField(HasLabel<PointT>::value);
    append(Sensor::cloud, toLabelledCloud(cloud), Eigen::Isometry3d::Identity(), 0);
  }
  /// A scan in the frame of the sensor [m], at its pose: p_odom = T_odom_sensor * p, where the
  /// odometry drifts by some percent of the path length at most. `stamp_s`: time of the scan [s].
  /// Throws UsageError as above, and if the pose is no rigid motion.
  template <class PointT>
  void add(const pcl::PointCloud<PointT>& scan, const Eigen::Isometry3d& T_odom_sensor,
           double stamp_s = 0) {
    requireField(HasLabel<PointT>::value);
    append(Sensor::lidar, toLabelledCloud(scan), T_odom_sensor, stamp_s);
  }

  std::size_t size() const override { return frames_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override;
  double stamp(std::size_t index) const override;
  std::int64_t number(std::size_t index) const override;
  Frame read(std::size_t index) const override;
  Sensor sensor() const override;  ///< of the first cloud; cloud if there is none
  const LabelSet& labels() const override { return labels_; }
  const std::string& name() const override { return name_; }
  LeftOut leftOut() const override;

 private:
  const Frame& at(std::size_t index) const;  ///< throws UsageError
  void requireField(bool has_label) const;
  void append(Sensor sensor, LabelledCloud cloud, const Eigen::Isometry3d& T_odom_sensor,
              double stamp_s);

  LabelSet labels_;
  std::string name_;
  std::vector<Frame> frames_;
};

}  // namespace xview
