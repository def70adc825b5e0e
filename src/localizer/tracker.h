// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "xview/localizer.h"

namespace xview {

/// The answer to one query of a recording that is being followed.
struct TrackAnswer {
  Localization fix;     ///< with the pose of the last frame, T_map_sensor [m, map frame]
  bool local = false;   ///< found where it was expected; else the whole map was searched
  bool lost = false;    ///< it was expected somewhere, but does not agree with the map there
  double radius_m = 0;  ///< of the expectation, horizontally [m]; 0 if there was none
};

/// Follows a robot from fix to fix: the last accepted pose and the odometry since then say where
/// the next query is expected, the covariance of the fix and the drift of the odometry how far
/// around. Only there is searched. A query that does not agree with the map there is searched for
/// in the whole map; until one is found the expectation grows, beyond a radius of 20 m (of a town;
/// less in smaller places) there is none.
///
///     xview::Tracker tracker(localizer);
///     const auto answer = tracker.add(cloud, T_odom_sensor, stamp_s);  // for every scan
class Tracker {
 public:
  /// The localizer must outlive the tracker. Of the options, those of the odometry are used.
  /// `window`: number of added frames that make one query, at least 1.
  Tracker(const Localizer& localizer, const Options& options, std::size_t window = 1);
  explicit Tracker(const Localizer& localizer) : Tracker(localizer, localizer.options()) {}
  Tracker(Localizer&&, const Options&, std::size_t = 1) = delete;
  explicit Tracker(Localizer&&) = delete;

  /// The queries must be windows of one recording, in order (one odometry frame).
  TrackAnswer follow(const Query& query);
  /// The query was found otherwise, with this accepted answer; the next one is expected from there.
  void begin(const Query& query, const Localization& fix);

  /// Adds a frame as it comes, with its odometry pose T_odom_sensor; every `window` frames are a
  /// query that is followed, without an answer for those before. `labels`: its classes; without
  /// them they come from shapes. Throws as Localizer::preprocess().
  std::optional<TrackAnswer> add(const Frame& frame, const LabelSet& labels = {});
  /// The same for a scan of PCL in the frame of the sensor [m]; see CloudRecording.
  template <class PointT>
  std::optional<TrackAnswer> add(const pcl::PointCloud<PointT>& scan,
                                 const Eigen::Isometry3d& T_odom_sensor, double stamp_s = 0,
                                 const LabelSet& labels = {}) {
    CloudRecording alone(labels);
    alone.add(scan, T_odom_sensor, stamp_s);
    Frame frame = alone.read(0);
    frame.number = added_;
    return add(frame, labels);
  }

 private:
  struct Fix {
    Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_query_sensor = Eigen::Isometry3d::Identity();  ///< where it was found
    double sigma_m = 0, sigma_rad = 0;
    double travelled_m = 0;  ///< since then
  };
  std::optional<ExpectedPose> expectation(const Query& query);

  const Localizer& localizer_;
  const Options options_;
  const std::size_t window_;
  std::optional<Fix> fix_;
  std::vector<PreprocessedFrame> frames_;  ///< since the last query
  std::int64_t added_ = 0;
};

}  // namespace xview
