// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/localizer.h"

namespace xview {

/// The answer to one query of a recording that is being followed.
struct TrackAnswer {
  Localization fix;     ///< with the pose of the last frame, T_map_sensor [m, map frame]
  bool local = false;   ///< found where it was expected; else the whole map was searched
  bool lost = false;    ///< it was expected somewhere, but does not agree with the map there
  double radius_m = 0;  ///< of the expectation, horizontally [m]; 0 if there was none
  double jump_m = 0;    ///< as in FollowAnswer
};

/// Follows a robot from fix to fix: the last accepted pose and the odometry since then say where
/// the next query is expected, the covariance of the fix and the drift of the odometry how far
/// around. Only there is searched. A query that does not agree with the map there is searched for
/// in the whole map; until one is found the expectation grows, beyond a radius of 20 m (of a town;
/// less in smaller places) there is none.
class Tracker {
 public:
  /// The localizer must outlive the tracker. Of the options, those of the odometry are used.
  Tracker(const Localizer& localizer, const Options& options)
      : localizer_(localizer), options_(options) {}

  /// The queries must be windows of one recording, in order (one odometry frame).
  TrackAnswer follow(const Query& query);
  /// The query was found otherwise, with this accepted answer; the next one is expected from there.
  void begin(const Query& query, const Localization& fix);

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
  std::optional<Fix> fix_;
};

}  // namespace xview
