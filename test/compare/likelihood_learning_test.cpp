// SPDX-License-Identifier: BSD-3-Clause
#include "compare/likelihood_learning.h"

#include <gtest/gtest.h>

#include <numeric>

#include "localizer/simulated_drive.h"

namespace xview {
namespace {

double nearShare(const std::array<double, search::kDistanceBins>& counts) {
  return (counts[0] + counts[1]) / std::accumulate(counts.begin(), counts.end(), 0.0);
}

std::vector<Eigen::Isometry3d> truthOf(const SimulatedRecording& recording) {
  std::vector<Eigen::Isometry3d> truth;
  for (std::size_t i = 0; i < recording.size(); ++i) truth.push_back(recording.truth(i));
  return truth;
}

TEST(LikelihoodLearning, SamplesLieNearerAtTruePosesThanAtWrongOnes) {
  const auto& drive = test::simulatedDrive();
  const auto& rear = drive.sessions.at("rear");
  const search::LikelihoodTable table =
      learnLikelihoods(drive.map, drive.frames.at("rear"), truthOf(*rear), 40, {});
  for (const BevChannel channel :
       {BevChannel::road, BevChannel::building, BevChannel::fence, BevChannel::obstacle_low}) {
    const search::DistanceCounts& counts = table.at(search::Viewpoint::ground, channel);
    EXPECT_GT(nearShare(counts.at_true), nearShare(counts.at_wrong)) << toString(channel);
  }
  const search::DistanceCounts& from_the_air = table.at(search::Viewpoint::air, BevChannel::road);
  EXPECT_EQ(std::accumulate(from_the_air.at_true.begin(), from_the_air.at_true.end(), 0.0), 0);
}

Eigen::Isometry3d tiltBy(double degrees) {
  return Eigen::Isometry3d(
      Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d(1, 2, 0).normalized()));
}

TEST(LikelihoodLearning, CountsTheSameInTiltedFrames) {
  const auto& drive = test::simulatedDrive();
  const auto& rear = *drive.sessions.at("rear");
  const search::LikelihoodTable upright =
      learnLikelihoods(drive.map, drive.frames.at("rear"), truthOf(rear), 40, {});
  const Eigen::Isometry3d T_tilted_map = tiltBy(35), T_tilted_odom = tiltBy(-50);
  const PosedRecording forward(*drive.sessions.at("forward"), T_tilted_map);
  const map::SemanticMap map = buildMap({&forward}, {});
  ASSERT_GT(map.bev.alignment.angularDistance(Eigen::Quaterniond::Identity()), 0.5);
  std::vector<Eigen::Isometry3d> truth = truthOf(rear);
  for (Eigen::Isometry3d& T : truth) T = T_tilted_map * T;
  const search::LikelihoodTable tilted =
      learnLikelihoods(map, test::movedFrames(rear, T_tilted_odom), truth, 40, {});
  for (const BevChannel channel :
       {BevChannel::road, BevChannel::building, BevChannel::fence, BevChannel::obstacle_low}) {
    const search::DistanceCounts& a = upright.at(search::Viewpoint::ground, channel);
    const search::DistanceCounts& b = tilted.at(search::Viewpoint::ground, channel);
    EXPECT_NEAR(nearShare(b.at_true), nearShare(a.at_true), 0.1) << toString(channel);
    EXPECT_GT(nearShare(b.at_true), nearShare(b.at_wrong)) << toString(channel);
  }
}

}  // namespace
}  // namespace xview
