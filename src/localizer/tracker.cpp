// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localizer/query_check.h"
#include "place/sound_input.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr double kSigmas = 3;
// Least radius [m] and difference of heading [deg] of the search around the expected pose, in a
// town.
constexpr double kMinRadius_m = 3, kMinYaw_deg = 6;
// Beyond this radius the whole map is searched again [m].
constexpr double kMaxRadius_m = 20;

/// The way from the pose of the last fix, along those frames of the query that come after it.
double travelledSince(const Eigen::Isometry3d& T_query_sensor,
                      const std::vector<Eigen::Isometry3d>& poses) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if ((poses[i].translation() - T_query_sensor.translation()).squaredNorm() <
        (poses[nearest].translation() - T_query_sensor.translation()).squaredNorm()) {
      nearest = i;
    }
  }
  double travelled = (poses[nearest].translation() - T_query_sensor.translation()).norm();
  for (std::size_t i = nearest + 1; i < poses.size(); ++i)
    travelled += (poses[i].translation() - poses[i - 1].translation()).norm();
  return travelled;
}

}  // namespace

std::optional<ExpectedPose> Tracker::expectation(const Query& query) {
  if (!fix_) return std::nullopt;
  const OdometryOptions& odometry = options_.odometry;
  const double travelled = fix_->travelled_m + travelledSince(fix_->T_query_sensor, query.poses);
  ExpectedPose expected;
  // The lever: an error of the heading at the fix moves what lies ahead.
  const double size = localizer_.size();
  expected.radius_m = kMinRadius_m * size +
                      kSigmas * std::hypot(fix_->sigma_m, fix_->sigma_rad * travelled) +
                      odometry.drift * travelled;
  expected.yaw_rad = kMinYaw_deg * M_PI / 180 + kSigmas * fix_->sigma_rad +
                     odometry.drift_deg_per_m * M_PI / 180 * travelled;
  if (!(expected.radius_m <= kMaxRadius_m * size) || !std::isfinite(expected.yaw_rad)) {
    fix_.reset();
    return std::nullopt;
  }
  expected.T_map_query = fix_->T_map_query;
  return expected;
}

void Tracker::begin(const Query& query, const Localization& fix) {
  requireSound(query);
  const Matrix6d& c = fix.covariance;
  const double largest = std::max(c(0, 0), c(1, 1)) +
                         std::abs(c(0, 1));  // bounds the variance along any direction of the plane
  fix_ = Fix{fix.T_map_query, query.poses.back(), std::sqrt(std::max(0.0, largest)),
             std::sqrt(std::max(0.0, c(5, 5))), 0};
}

TrackAnswer Tracker::follow(const Query& query) {
  TrackAnswer answer;
  requireSound(query);
  if (!query.jumps.empty()) fix_.reset();  // its odometry leads nowhere from there
  bool is_cut = false;                     // then there is no time for the whole map
  if (const auto expected = expectation(query)) {
    answer.radius_m = expected->radius_m;
    answer.fix = localizer_.localize(query, *expected);
    answer.local = answer.fix.accepted();
    is_cut = !answer.local && isBudgetSpent();
    answer.lost = !answer.local && !is_cut;
  }
  if (!answer.local && !is_cut) {
    Timings spent;
    if (answer.lost) spent.emplace_back("track", answer.fix.timing_ms.back().second);
    answer.fix = localizer_.localize(query);
    answer.fix.timing_ms.insert(answer.fix.timing_ms.begin(), spent.begin(), spent.end());
  }
  if (answer.fix.accepted()) {
    begin(query, answer.fix);
  } else if (fix_) {
    fix_->travelled_m += travelledSince(fix_->T_query_sensor, query.poses);
    fix_->T_query_sensor = query.poses.back();
  }
  return answer;
}

}  // namespace xview
