// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "localizer/simulated_drive.h"

namespace xview {
namespace {

/// Along a street that shows little lengthwise a pose may slip, but not as far as another place.
constexpr double kTrackedSlip_m = 3;

using test::simulatedDrive;

constexpr std::size_t kWindow = 12, kStride = 6;

double errorOfTrack(const Localization& fix, const std::string& session, std::size_t frame) {
  return (fix.T_map_sensor.translation() -
          simulatedDrive().sessions.at(session)->truth(frame).translation())
      .norm();
}

TEST(Tracker, FollowsTheDriveWhereOdometryExpectsIt) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Tracker tracker(localizer, {});
  int accepted = 0, local = 0, windows = 0;
  for (std::size_t first = 0; first + kWindow <= drive.frames.at("rear").size();
       first += kStride, ++windows) {
    const TrackAnswer answer = tracker.follow(drive.query("rear", first, first + kWindow));
    local += answer.local;
    accepted += answer.fix.accepted();
    if (answer.fix.accepted()) {
      EXPECT_LT(errorOfTrack(answer.fix, "rear", first + kWindow - 1), kTrackedSlip_m)
          << "from " << first;
    }
  }
  EXPECT_GE(local, accepted - 1) << "only the first fix needs the whole map";
  EXPECT_GE(accepted, windows * 2 / 3);
}

TEST(Tracker, ExpectsWithinThreeSigmaOfTheFixAndTheDriftSince) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Tracker tracker(localizer, {});
  const Localization fix = tracker.follow(drive.query("rear", 0, 24)).fix;
  ASSERT_TRUE(fix.accepted()) << fix.reason;
  const Matrix6d& c = fix.covariance;
  const double sigma_m = std::sqrt(std::max(c(0, 0), c(1, 1)) + std::abs(c(0, 1)));
  constexpr double kMinRadius_m = 3;
  const double at_once = tracker.follow(drive.query("rear", 0, 24)).radius_m;
  EXPECT_NEAR(at_once, kMinRadius_m + 3 * sigma_m, 1e-9);
  EXPECT_GT(sigma_m, 1e-4);
  EXPECT_GT(tracker.follow(drive.query("rear", 6, 30)).radius_m, at_once);
}

TEST(Tracker, SaysThatItIsLostAndSearchesEverywhere) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Tracker tracker(localizer, {});
  const std::size_t end = drive.frames.at("rear").size();
  ASSERT_TRUE(tracker.follow(drive.query("rear", 0, 24)).fix.accepted());
  // The robot is carried on while its odometry stands still.
  const Eigen::Vector3d from = drive.frames.at("rear")[23].T_odom_sensor.translation();
  const Eigen::Vector3d to = drive.frames.at("rear")[end - 1].T_odom_sensor.translation();
  const auto carried = test::movedFrames(*drive.sessions.at("rear"), poseFromYaw(from - to, 0));
  const TrackAnswer answer =
      tracker.follow(makeQuery(carried.data() + end - 24, carried.data() + end, drive.labels, {}));
  EXPECT_TRUE(answer.lost);
  EXPECT_FALSE(answer.local);
  EXPECT_TRUE(answer.fix.accepted()) << answer.fix.reason;
  EXPECT_LT(errorOfTrack(answer.fix, "rear", end - 1), 0.5);
}

TEST(Tracker, ExpectsLessAndLessUntilItExpectsNothing) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Options options;
  options.odometry.drift = 0.2;
  Tracker tracker(localizer, options);
  ASSERT_TRUE(tracker.follow(drive.query("rear", 0, 24)).fix.accepted());
  Query nothing = drive.query("rear", 0, 24);
  nothing.bev = {};
  nothing.graph = {};
  nothing.cloud = {};
  double before = 0;
  bool gave_up = false;
  for (int step = 0; step < 40 && !gave_up; ++step) {
    for (Eigen::Isometry3d& T : nothing.poses) T.translation().x() += 10;
    const TrackAnswer answer = tracker.follow(nothing);
    EXPECT_FALSE(answer.fix.accepted());
    gave_up = answer.radius_m == 0;
    EXPECT_EQ(answer.lost, !gave_up);
    if (!gave_up) {
      EXPECT_GT(answer.radius_m, before);
    }
    before = answer.radius_m;
  }
  EXPECT_TRUE(gave_up);
}

TEST(Tracker, AcceptsNothingOfAnotherTown) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Tracker tracker(localizer, {});
  for (std::size_t first = 0; first + kWindow <= drive.frames.at("elsewhere").size();
       first += kWindow) {
    EXPECT_FALSE(tracker.follow(drive.query("elsewhere", first, first + kWindow)).fix.accepted())
        << "from " << first;
  }
}

TEST(Tracker, CarriedToAnotherTownItAcceptsNothing) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  for (std::size_t first = 0; first + kWindow <= drive.frames.at("elsewhere").size();
       first += kWindow) {
    Tracker tracker(localizer, {});
    ASSERT_TRUE(tracker.follow(drive.query("rear", 10, 40)).fix.accepted());
    const Eigen::Isometry3d T_carried =
        drive.frames.at("rear")[39].T_odom_sensor *
        drive.frames.at("elsewhere")[first + kWindow - 1].T_odom_sensor.inverse();
    const auto moved = test::movedFrames(*drive.sessions.at("elsewhere"), T_carried);
    const TrackAnswer answer = tracker.follow(
        makeQuery(moved.data() + first, moved.data() + first + kWindow, drive.labels, {}));
    EXPECT_FALSE(answer.fix.accepted()) << "from " << first << ": " << answer.fix.reason;
  }
}

}  // namespace
}  // namespace xview
