// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "scenes.h"

namespace xview {

using namespace graph;

namespace {

using namespace test;

const MergeOptions kMean = mergeOptions("running_mean");

/// A blob with a box around it.
Blob boxAt(std::uint32_t label, double x, double y, double size) {
  Blob blob = blobAt(label, x, y, 0);
  blob.min = blob.position - Eigen::Vector3d::Constant(size / 2);
  blob.max = blob.position + Eigen::Vector3d::Constant(size / 2);
  return blob;
}

TEST(LabelVote, AVertexHasTheLabelThatMostObservationsSay) {
  const auto vertices = merged(kMean, {{boxAt(kBench, 0, 0, 1)},
                                       {boxAt(kPole, 0.2, 0, 1)},
                                       {boxAt(kPole, 0.1, 0, 1)},
                                       {boxAt(kBench, -0.1, 0, 1)},
                                       {boxAt(kPole, 0.3, 0, 1)}});
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_EQ(vertices[0].label, kPole);
  EXPECT_EQ(vertices[0].observations, 5u);
  EXPECT_EQ(vertices[0].first_frame, 0);
  EXPECT_EQ(vertices[0].last_frame, 4);
  EXPECT_NEAR(vertices[0].position.x(), 0.1, 1e-12);
  EXPECT_EQ(vertices[0].points, 250u);
  // the spread of all five observations about their mean, per axis
  EXPECT_NEAR(vertices[0].sigma_m, std::sqrt(0.02 / 3), 1e-12);
}

TEST(LabelVote, ThingsThatAreSeenTogetherStayTwo) {
  const std::vector<std::vector<Blob>> frames(6, {boxAt(kBench, 0, 0, 1), boxAt(kPole, 0.2, 0, 1)});
  EXPECT_EQ(merged(kMean, frames).size(), 2u);
}

TEST(LabelVote, ThingsBesideOneAnotherStayTwo) {
  const auto seenInTurn = [](const Blob& a, const Blob& b) {
    return merged(kMean, {{a}, {a}, {a}, {b}, {a}}).size();
  };
  EXPECT_EQ(seenInTurn(boxAt(kBench, 0, 0, 1), boxAt(kPole, 0.2, 0, 1)), 1u);
  EXPECT_EQ(seenInTurn(boxAt(kBench, 0, 0, 1), boxAt(kPole, 0.8, 0, 1)), 2u);
  EXPECT_EQ(seenInTurn(boxAt(kBench, 0, 0, 9), boxAt(kPole, 1.5, 0, 9)), 2u);
  EXPECT_EQ(seenInTurn(boxAt(kCar, 0, 0, 1), boxAt(kPole, 0, 0, 1)), 2u) << "one of them moves";
}

TEST(LabelVote, NeedsThreeFramesThatSayTheSame) {
  EXPECT_EQ(
      merged(kMean, {{boxAt(kBench, 0, 0, 1)}, {boxAt(kBench, 0, 0, 1)}, {boxAt(kPole, 0, 0, 1)}})
          .size(),
      2u);
}

TEST(LabelVote, FramesOfTwoRecordingsAreNotTakenForOne) {
  // Both recordings begin with frame 0: the first sees a bench where the second sees a pole.
  PlaceGraphBuilder builder(townLabels(), kMean);
  for (int frame = 0; frame < 3; ++frame) builder.add({boxAt(kBench, 0, 0, 1)}, frame);
  for (int frame = 0; frame < 4; ++frame) builder.add({boxAt(kPole, 0, 0, 1)}, frame);
  ASSERT_EQ(builder.graph().size(), 1u);
  EXPECT_EQ(builder.graph().vertices[0].label, kPole);
  EXPECT_EQ(builder.graph().vertices[0].observations, 7u);
}

TEST(LabelVote, KeepsTheEdgesOfAllLabels) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.addImageBlobs({boxAt(kBench, 0, 0, 1), boxAt(kRoad, 0, 20, 1)}, {{0, 1}}, 0);
  builder.addImageBlobs({boxAt(kPole, 0, 0, 1), boxAt(kCar, 9, 0, 1)}, {{0, 1}}, 1);
  builder.addImageBlobs({boxAt(kPole, 0, 0, 1)}, {}, 2);
  builder.addImageBlobs({boxAt(kPole, 0, 0, 1)}, {}, 3);
  const SemanticGraph graph = builder.graph();
  EXPECT_TRUE(isConsistent(graph));
  ASSERT_EQ(graph.size(), 3u);
  EXPECT_EQ(graph.edgeCount(), 2u);
}

}  // namespace
}  // namespace xview
