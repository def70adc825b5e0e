// SPDX-License-Identifier: BSD-3-Clause
// What the points of a frame count in the place graph.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pipeline/simulated_drive.h"
#include "xview/mapper.h"

namespace xview {
namespace {

constexpr float kVoxel_m = 0.2F;  // of the plan

std::uint32_t idOf(const std::string& name) {
  for (const auto& [id, info] : test::simulatedDrive().labels.classes()) {
    if (info.name == name) return id;
  }
  ADD_FAILURE() << "no class " << name;
  return 0;
}

/// So many points of a class in the middle of each voxel of a row.
void addRow(int voxels, int points_in_each, std::uint32_t label, float y, LabelledCloud& cloud) {
  for (int v = 0; v < voxels; ++v) {
    for (int k = 0; k < points_in_each; ++k)
      cloud.points.emplace_back(kVoxel_m * (static_cast<float>(v) + 0.5F), y, 0.1F, label);
  }
}

Frame frameOf(LabelledCloud cloud, Sensor sensor) {
  Frame frame;
  frame.sensor = sensor;
  frame.cloud = std::move(cloud);
  return frame;
}

/// By the row of the voxels.
std::map<int, float> votesOf(const FrameDigest& digest) {
  std::map<int, float> votes;
  for (std::size_t i = 0; i < digest.cloud.size(); ++i)
    votes[static_cast<int>(digest.cloud.points[i].y)] = digest.votes[i];
  return votes;
}

FrameDigest digestOf(const LabelledCloud& cloud, Sensor sensor = Sensor::cloud) {
  return digestFrame(frameOf(cloud, sensor), test::simulatedDrive().labels, Options());
}

/// A street and what was measured badly from afar.
LabelledCloud scatteredCloud() {
  LabelledCloud cloud;
  addRow(50, 40, idOf("road"), 1.1F, cloud);
  addRow(50, 12, idOf("road"), 3.1F, cloud);
  addRow(900, 1, idOf("road"), 5.1F, cloud);
  return cloud;
}

TEST(Votes, OfSparseSurfacesInAScatteredCloudAreLow) {
  const auto votes = votesOf(digestOf(scatteredCloud()));
  EXPECT_FLOAT_EQ(votes.at(1), 2);
  EXPECT_FLOAT_EQ(votes.at(3), 0.5);
  EXPECT_LT(votes.at(5), 0.002);
}

TEST(Votes, OfObjectsInAScatteredCloudDoNotDependOnItsDensity) {
  LabelledCloud cloud = scatteredCloud();
  addRow(3, 2, idOf("pole"), 7.1F, cloud);
  EXPECT_FLOAT_EQ(votesOf(digestOf(cloud)).at(7), 1);
}

TEST(Votes, OfSharpCloudsDoNotDependOnTheirDensity) {
  LabelledCloud cloud;
  addRow(50, 30, idOf("road"), 1.1F, cloud);
  addRow(50, 5, idOf("road"), 3.1F, cloud);
  addRow(50, 1, idOf("building"), 5.1F, cloud);
  const auto votes = votesOf(digestOf(cloud));
  EXPECT_FLOAT_EQ(votes.at(1), 2);
  EXPECT_FLOAT_EQ(votes.at(3), 2);
  EXPECT_FLOAT_EQ(votes.at(5), 0.5);
}

TEST(Votes, OfPlacesWhereTheSensorStoodDoNotSilenceTheRest) {
  LabelledCloud cloud;
  addRow(5, 100000, idOf("road"), 1.1F, cloud);
  addRow(500, 6, idOf("road"), 3.1F, cloud);
  EXPECT_FLOAT_EQ(votesOf(digestOf(cloud)).at(3), 2);
}

TEST(Votes, OfScansDoNotDependOnTheirDensity) {
  const auto votes = votesOf(digestOf(scatteredCloud(), Sensor::lidar));
  EXPECT_NEAR(votes.at(1), votes.at(3), 0.2);
}

TEST(Votes, OfAnEmptyCloudAreNone) { EXPECT_TRUE(digestOf(LabelledCloud()).votes.empty()); }

}  // namespace
}  // namespace xview
