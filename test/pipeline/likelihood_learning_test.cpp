// SPDX-License-Identifier: BSD-3-Clause
#include "xview/likelihood_learning.h"

#include <gtest/gtest.h>

#include <numeric>

#include "pipeline/simulated_drive.h"

namespace xview {
namespace {

double nearShare(const std::array<double, search::kDistanceBins>& counts) {
  return (counts[0] + counts[1]) / std::accumulate(counts.begin(), counts.end(), 0.0);
}

TEST(LikelihoodLearning, SamplesLieNearerAtTruePosesThanAtWrongOnes) {
  const auto& drive = test::simulatedDrive();
  const auto& rear = drive.sessions.at("rear");
  std::vector<Eigen::Isometry3d> truth;
  for (std::size_t i = 0; i < rear->size(); ++i) truth.push_back(rear->truth(i));
  const search::LikelihoodTable table =
      learnLikelihoods(drive.map, drive.frames.at("rear"), truth, 40, {});
  for (const Channel channel :
       {Channel::road, Channel::building, Channel::fence, Channel::obstacle_low}) {
    const search::DistanceCounts& counts = table.at(search::Viewpoint::ground, channel);
    EXPECT_GT(nearShare(counts.at_true), nearShare(counts.at_wrong)) << toString(channel);
  }
  const search::DistanceCounts& from_the_air = table.at(search::Viewpoint::air, Channel::road);
  EXPECT_EQ(std::accumulate(from_the_air.at_true.begin(), from_the_air.at_true.end(), 0.0), 0);
}

}  // namespace
}  // namespace xview
