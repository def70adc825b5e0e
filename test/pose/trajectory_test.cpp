// SPDX-License-Identifier: BSD-3-Clause
#include "pose/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace xview::pose {
namespace {

/// A drive along x, a pose every metre.
std::vector<Eigen::Isometry3d> drive(int metres) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i <= metres; ++i)
    poses.emplace_back(Eigen::Translation3d(static_cast<double>(i), 0, 0));
  return poses;
}

/// Of a drive whose odometry frame lies `y` to the left in the map.
TrajectoryFix fixAt(std::size_t index, double y) {
  TrajectoryFix fix;
  fix.index = index;
  fix.T_map_query.translation().y() = y;
  fix.T_map_sensor.translation() = Eigen::Vector3d(static_cast<double>(index), y, 0);
  return fix;
}

TEST(Trajectory, OfOneFixIsTheOdometryMoved) {
  const auto poses = trajectoryThrough(drive(10), {fixAt(4, 2)});
  ASSERT_EQ(poses.size(), 11u);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_TRUE(poses[i].translation().isApprox(Eigen::Vector3d(static_cast<double>(i), 2, 0)));
}

TEST(Trajectory, SpreadsTheDisagreementOfTwoFixesAlongTheWayBetweenThem) {
  const auto poses = trajectoryThrough(drive(10), {fixAt(2, 0), fixAt(6, 4)});
  for (const std::size_t i : {0, 1, 2}) EXPECT_NEAR(poses[i].translation().y(), 0, 1e-12);
  EXPECT_NEAR(poses[3].translation().y(), 1, 1e-12);
  EXPECT_NEAR(poses[5].translation().y(), 3, 1e-12);
  for (const std::size_t i : {6, 7, 10}) EXPECT_NEAR(poses[i].translation().y(), 4, 1e-12);
}

TEST(Trajectory, TurnsTheShortWayBetweenTwoFixes) {
  TrajectoryFix turned = fixAt(4, 0);
  turned.T_map_query.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  turned.T_map_sensor = turned.T_map_query * drive(4).back();
  const auto poses = trajectoryThrough(drive(4), {fixAt(0, 0), turned});
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_NEAR(Eigen::AngleAxisd(poses[i].linear()).angle(), 0.1 * static_cast<double>(i), 1e-9);
}

TEST(Trajectory, IsWhatAFixFoundOfTheWayBeforeIt) {
  TrajectoryFix fix = fixAt(6, 4);
  for (int i = 3; i <= 6; ++i)
    fix.way.emplace_back(Eigen::Translation3d(static_cast<double>(i), 4 - 0.5 * (6 - i), 0));
  const auto poses = trajectoryThrough(drive(10), {fix});
  EXPECT_NEAR(poses[4].translation().y(), 3, 1e-12);
  EXPECT_NEAR(poses[0].translation().y(), 2.5, 1e-12) << "as far from the first as odometry says";
  EXPECT_NEAR(poses[10].translation().y(), 4, 1e-12);
}

TEST(Trajectory, GoesOnFromAFixWithTheLengthsThatItFound) {
  TrajectoryFix fix = fixAt(6, 0);
  for (int i = 4; i <= 6; ++i)
    fix.way.emplace_back(Eigen::Translation3d(6 + 1.1 * (i - 6), 0, 0));
  const auto poses = trajectoryThrough(drive(10), {fix});
  EXPECT_NEAR(poses[10].translation().x(), 10.4, 1e-12);
  EXPECT_NEAR(poses[0].translation().x(), -0.6, 1e-12);
}

TEST(Trajectory, OfAStandingRecordingJumpsToTheLaterFix) {
  const std::vector<Eigen::Isometry3d> standing(3, Eigen::Isometry3d::Identity());
  const auto poses = trajectoryThrough(standing, {fixAt(0, 0), fixAt(2, 4)});
  EXPECT_NEAR(poses[1].translation().y(), 4, 1e-12);
  EXPECT_TRUE(poses[1].matrix().allFinite());
}

TEST(Trajectory, IsInTheLengthsOfTheMap) {
  TrajectoryFix fix = fixAt(0, 0);
  fix.scale = 2;
  EXPECT_NEAR(trajectoryThrough(drive(3), {fix}).back().translation().x(), 6, 1e-12);
}

/// A fix of a drive whose odometry has `scale` times the way.
TrajectoryFix fixOnTheWay(std::size_t index, double scale) {
  TrajectoryFix fix = fixAt(index, 0);
  fix.T_map_sensor.translation().x() = static_cast<double>(index) / scale;
  return fix;
}

std::size_t toldOf(double scale, const std::vector<std::size_t>& indices) {
  const std::vector<Eigen::Isometry3d> poses = drive(100);
  std::vector<double> way_m;
  for (const Eigen::Isometry3d& T : poses) way_m.push_back(T.translation().x());
  std::vector<TrajectoryFix> fixes;
  for (const std::size_t i : indices) fixes.push_back(fixOnTheWay(i, scale));
  const std::vector<bool> told = toldByOdometry(fixes, poses, way_m, 1);
  return static_cast<std::size_t>(std::count(told.begin(), told.end(), true));
}

TEST(Trajectory, OdometryTellsFramesBetweenFixesThatItConnects) {
  EXPECT_EQ(toldOf(1, {10, 90}), 101u) << "all";
  EXPECT_EQ(toldOf(1.02, {10, 90}), 101u) << "a usual drift";
  EXPECT_EQ(toldOf(1.1, {10, 90}), 20u) << "10 m before the first fix and behind the last one";
  EXPECT_EQ(toldOf(1, {50}), 21u) << "one fix shows no error";
  EXPECT_EQ(toldOf(1.1, {10, 20}), 31u) << "too near to each other to show one";
}

}  // namespace
}  // namespace xview::pose
