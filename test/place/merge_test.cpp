// SPDX-License-Identifier: BSD-3-Clause
#include "place/merge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes.h"
#include "xview/base/error.h"

namespace xview {

namespace {

using namespace test;

const MergeOptions kMean = mergeOptions("running_mean");
const MergeOptions kFirst = mergeOptions("first_observation");

/// Frames along a street: objects at least 5 m apart, each seen with a little noise from frames
/// near it.
std::vector<std::vector<Blob>> driveAlong(double noise_m, Random& random) {
  std::vector<Blob> things;
  for (int i = 0; i < 40; ++i) {
    things.push_back(blobAt(i % 3 == 0   ? kCar
                            : i % 3 == 1 ? kPole
                                         : kBench,
                            5.0 * i, random.uniform(-4, 4), 1));
  }
  std::vector<std::vector<Blob>> frames;
  for (double x = 0; x < 200; x += 2) {
    frames.emplace_back();
    for (const Blob& thing : things) {
      if (std::abs(thing.position.x() - x) > 15) continue;
      frames.back().push_back(thing);
      for (int axis = 0; axis < 3; ++axis) {
        frames.back().back().position[axis] += noise_m * random.normal();
      }
    }
  }
  return frames;
}

TEST(RunningMean, OfRepeatedObservationsIsOneVertexAtTheMean) {
  const auto vertices = merged(kMean, {{blobAt(kPole, 0, 0, 0, 10)},
                                       {blobAt(kPole, 1, 0, 0, 30)},
                                       {blobAt(kPole, 0.75, 0, 0, 40)}});
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_NEAR(vertices[0].position.x(), 0.75, 1e-12);
  EXPECT_EQ(vertices[0].observations, 3u);
  EXPECT_EQ(vertices[0].points, 80u);
  EXPECT_EQ(vertices[0].first_frame, 0);
  EXPECT_EQ(vertices[0].last_frame, 2);
  // per axis: sqrt((10 * 0.75^2 + 30 * 0.25^2) / 80 / 3)
  EXPECT_NEAR(vertices[0].sigma_m, std::sqrt(7.5 / 80 / 3), 1e-12);
}

TEST(RunningMean, CapsTheWeightOfACloseView) {
  const auto vertices =
      merged(kMean, {{blobAt(kCar, 0, 0, 0, 200)}, {blobAt(kCar, 1, 0, 0, 1000000)}});
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_NEAR(vertices[0].position.x(), 0.5, 1e-12);
  EXPECT_EQ(vertices[0].points, 1000200u);
}

TEST(RunningMean, PairsNearestFirstAndEachVertexWithOneBlob) {
  // Two poles 1.5 m apart stay two, although each is within reach of both.
  const std::vector<Blob> two{blobAt(kPole, 0, 0, 0), blobAt(kPole, 1.5, 0, 0)};
  const std::vector<Blob> swapped{blobAt(kPole, 1.4, 0, 0), blobAt(kPole, 0.2, 0, 0)};
  const auto vertices = merged(kMean, {two, swapped, two});
  ASSERT_EQ(vertices.size(), 2u);
  EXPECT_NEAR(vertices[0].position.x(), 0.2 / 3, 1e-12);
  EXPECT_NEAR(vertices[1].position.x(), 4.4 / 3, 1e-12);
  EXPECT_EQ(vertices[0].observations, 3u);
}

TEST(RunningMean, FollowsAVertexIntoTheNextCell) {
  MergeOptions options = kMean;
  options.object_m = 1;
  std::vector<std::vector<Blob>> frames;
  for (int i = 0; i < 20; ++i) frames.push_back({blobAt(kCar, 0.9 + 0.02 * i, 0, 0)});
  frames.push_back({blobAt(kCar, 2.05, 0, 0)});
  EXPECT_EQ(merged(options, frames).size(), 1u);
}

TEST(RunningMean, IsEquivariantToMotionForObjects) {
  Random random(1);
  const auto frames = driveAlong(0.1, random);
  const Eigen::Isometry3d T = randomPose(random);
  auto moved_frames = frames;
  for (auto& blobs : moved_frames) {
    for (Blob& blob : blobs) blob.position = T * blob.position;
  }
  const auto still = merged(kMean, frames), moved = merged(kMean, moved_frames);
  ASSERT_EQ(still.size(), 40u);
  ASSERT_EQ(moved.size(), still.size());
  for (std::size_t i = 0; i < still.size(); ++i) {
    EXPECT_EQ(moved[i].label, still[i].label);
    EXPECT_LT((moved[i].position - T * still[i].position).norm(), 1e-6);
    EXPECT_NEAR(moved[i].sigma_m, still[i].sigma_m, 1e-6);
  }
}

TEST(RunningMean, OfTwoPassesOverTheSameFramesHasTheSameVertices) {
  Random random(2);
  auto frames = driveAlong(0.15, random);
  const auto once = merged(kMean, frames);
  const std::size_t length = frames.size();
  for (std::size_t i = 0; i < length; ++i) frames.push_back(frames[i]);
  const auto twice = merged(kMean, frames);
  ASSERT_EQ(once.size(), 40u);
  ASSERT_EQ(twice.size(), once.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_LT((twice[i].position - once[i].position).norm(), 1e-9);
    EXPECT_EQ(twice[i].observations, 2 * once[i].observations);
    EXPECT_NEAR(twice[i].sigma_m, once[i].sigma_m, 1e-9);
  }
}

TEST(RunningMean, DoesNotDependOnTheOrderOfBlobsInAFrame) {
  Random random(3);
  auto frames = driveAlong(0.15, random);
  const auto forward = merged(kMean, frames);
  for (auto& blobs : frames) std::reverse(blobs.begin(), blobs.end());
  const auto backward = merged(kMean, frames);
  ASSERT_EQ(backward.size(), forward.size());
  for (const Vertex& a : forward) {
    EXPECT_EQ(1, std::count_if(backward.begin(), backward.end(), [&](const Vertex& b) {
                return a.label == b.label && (a.position - b.position).norm() < 1e-9;
              }));
  }
}

TEST(RunningMean, HasTheMeanExtent) {
  Blob small = blobAt(kCar, 0, 0, 0), large = small;
  small.max = small.min + Eigen::Vector3d(1, 1, 1);
  large.max = large.min + Eigen::Vector3d(3, 2, 1);
  const auto vertices = merged(kMean, {{small}, {large}});
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_LT((vertices[0].extent - Eigen::Vector3d(2, 1.5, 1)).norm(), 1e-12);
}

TEST(RunningMean, SamplesSurfacesOnceEverySpacing) {
  std::vector<Eigen::Vector3f> wall;
  for (int i = 0; i < 300; ++i) {
    for (int j = 0; j < 25; ++j) {
      wall.emplace_back(0.1f * static_cast<float>(i) + 0.05f, 1.5f,
                        0.1f * static_cast<float>(j) + 0.05f);
    }
  }
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.addSurfacePoints(cloudOf(wall, kBuilding), 4);
  builder.addSurfacePoints(cloudOf(wall, kBuilding), 6);
  const auto vertices = builder.graph().vertices;
  ASSERT_EQ(vertices.size(), 10u);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    EXPECT_LT(
        (vertices[i].position - Eigen::Vector3d(1.5 + 3.0 * static_cast<double>(i), 1.5, 1.25))
            .norm(),
        1e-4);
    EXPECT_EQ(vertices[i].label, kBuilding);
    EXPECT_EQ(vertices[i].observations, 2u);
    EXPECT_EQ(vertices[i].points, 1500u);
    EXPECT_EQ(vertices[i].first_frame, 4);
    EXPECT_LT((vertices[i].extent - Eigen::Vector3d(2.9, 0, 2.4)).norm(), 1e-3);
  }
}

TEST(RunningMean, SurfaceVerticesDoNotDependOnHowMuchWasSeen) {
  Random random(4);
  std::vector<Eigen::Vector3f> road;
  for (int i = 0; i < 20000; ++i) {
    road.emplace_back(random.uniform(0, 60), random.uniform(0, 9), random.uniform(0, 0.1));
  }
  const std::vector<Eigen::Vector3f> half(road.begin(), road.begin() + 10000);
  const auto graphOf = [](const std::vector<Eigen::Vector3f>& points) {
    PlaceGraphBuilder builder(townLabels(), kMean);
    builder.addSurfacePoints(cloudOf(points, kRoad), 0);
    return builder.graph().vertices;
  };
  const auto all = graphOf(road), some = graphOf(half);
  ASSERT_EQ(all.size(), 60u);
  ASSERT_EQ(some.size(), 60u);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_LT((all[i].position - some[i].position).norm(), 0.4);
  }
}

TEST(RunningMean, NeedsEnoughPointsForASurfaceVertex) {
  MergeOptions options = kMean;
  options.min_surface_points = 10;
  PlaceGraphBuilder builder(townLabels(), options);
  builder.addSurfacePoints(cloudOf(std::vector<Eigen::Vector3f>(6, {1, 1, 1}), kRoad), 0);
  EXPECT_TRUE(builder.graph().empty());
  builder.addSurfacePoints(cloudOf(std::vector<Eigen::Vector3f>(6, {1, 1, 1}), kRoad), 1);
  EXPECT_EQ(builder.graph().size(), 1u);
}

TEST(RunningMean, TakesSurfacesFromPointsAndThingsFromBlobsOnly) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.add({blobAt(kRoad, 0, 0, 0), blobAt(kCar, 0, 0, 0)}, 0);
  builder.addSurfacePoints(cloudOf({{0, 0, 0}}, kPole), 0);
  builder.addSurfacePoints(cloudOf({{0, 0, 0}}, kSky), 0);
  const auto vertices = builder.graph().vertices;
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_EQ(vertices[0].label, kCar);
}

TEST(FirstObservation, KeepsAVertexWhereItWasFirstSeen) {
  const auto vertices =
      merged(kFirst, {{blobAt(kPole, 0, 0, 0, 10)}, {blobAt(kPole, 9.9, 0, 0, 90)}});
  ASSERT_EQ(vertices.size(), 1u);
  EXPECT_EQ(vertices[0].position, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(vertices[0].observations, 2u);
  EXPECT_NEAR(vertices[0].sigma_m, std::sqrt(90 * 9.9 * 9.9 / 100 / 3), 1e-12);
}

TEST(FirstObservation, SpacesStreetsEvenly) {
  std::vector<std::vector<Blob>> frames;
  for (int i = 0; i <= 400; ++i) frames.push_back({blobAt(kRoad, 0.25 * i, 0, 0)});
  const auto vertices = merged(kFirst, frames);
  ASSERT_EQ(vertices.size(), 10u);
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    EXPECT_NEAR(vertices[i].position.x() - vertices[i - 1].position.x(), 10.25, 1e-9);
  }
}

TEST(FirstObservation, AbsorbsBlobsOfTheSameFrameAndIgnoresSurfacePoints) {
  PlaceGraphBuilder builder(townLabels(), kFirst);
  builder.add({blobAt(kRoad, 0, 0, 0), blobAt(kRoad, 3, 0, 0), blobAt(kRoad, 30, 0, 0)}, 0);
  builder.addSurfacePoints(cloudOf({{90, 0, 0}}, kRoad), 0);
  const auto vertices = builder.graph().vertices;
  ASSERT_EQ(vertices.size(), 2u);
  EXPECT_EQ(vertices[0].observations, 1u);  // frames, not blobs
  EXPECT_EQ(vertices[0].points, 100u);
}

TEST(FirstObservation, OfTwoPassesOverTheSameFramesHasTheSameVertices) {
  Random random(5);
  auto frames = driveAlong(0, random);
  const auto once = merged(kFirst, frames);
  const std::size_t length = frames.size();
  for (std::size_t i = 0; i < length; ++i) frames.push_back(frames[i]);
  const auto twice = merged(kFirst, frames);
  ASSERT_EQ(twice.size(), once.size());
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(twice[i].position, once[i].position);
}

class BothModes : public testing::TestWithParam<const char*> {};

TEST_P(BothModes, NeverMergeClasses) {
  EXPECT_EQ(merged(mergeOptions(GetParam()), {{blobAt(kPole, 0, 0, 0)}, {blobAt(kBench, 0, 0, 0)}})
                .size(),
            2u);
}

TEST_P(BothModes, NeverMergeDifferentInstancesButFillInMissingOnes) {
  Blob unknown = blobAt(kCar, 0, 0, 0), three = unknown, four = unknown;
  three.instance = 3;
  four.instance = 4;
  const auto vertices = merged(mergeOptions(GetParam()), {{unknown}, {three}, {four}, {three}});
  ASSERT_EQ(vertices.size(), 2u);
  EXPECT_EQ(vertices[0].instance, 3u);
  EXPECT_EQ(vertices[0].observations, 3u);
  EXPECT_EQ(vertices[1].instance, 4u);
}

TEST_P(BothModes, KeepTheOrderOfFirstObservation) {
  const auto vertices =
      merged(mergeOptions(GetParam()), {{blobAt(kPole, 50, 0, 0)},
                                        {blobAt(kCar, 0, 0, 0), blobAt(kPole, 50, 0, 0)},
                                        {blobAt(kBench, -90, 0, 0)}});
  ASSERT_EQ(vertices.size(), 3u);
  EXPECT_EQ(vertices[0].label, kPole);
  EXPECT_EQ(vertices[1].label, kCar);
  EXPECT_EQ(vertices[2].label, kBench);
  EXPECT_EQ(vertices[1].sigma_m, 0);
}

TEST_P(BothModes, BearNothingAndNonsense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(merged(mergeOptions(GetParam()), {}).empty());
  EXPECT_TRUE(merged(mergeOptions(GetParam()), {{}, {}}).empty());
  EXPECT_TRUE(merged(mergeOptions(GetParam()),
                     {{blobAt(kPole, nan, 0, 0), blobAt(kSky, 0, 0, 0), blobAt(77, 0, 0, 0)}})
                  .empty());
  EXPECT_EQ(
      merged(mergeOptions(GetParam()), {{blobAt(kPole, 1e300, 0, 0)}, {blobAt(kPole, 0, 0, 0, 0)}})
          .size(),
      2u);
}

INSTANTIATE_TEST_SUITE_P(Merge, BothModes, testing::Values("running_mean", "first_observation"));

TEST(Merge, RefusesAnUnknownMode) {
  EXPECT_THROW(PlaceGraphBuilder(townLabels(), mergeOptions("median")), UsageError);
}

TEST(Merge, CanGoOnAfterAGraphWasTaken) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.add({blobAt(kPole, 0, 0, 0)}, 0);
  EXPECT_EQ(builder.graph().size(), 1u);
  builder.add({blobAt(kPole, 0.5, 0, 0), blobAt(kPole, 20, 0, 0)}, 1);
  EXPECT_EQ(builder.graph().size(), 2u);
}

TEST(ImageGraph, JoinsVerticesWhoseBlobsWereNeighboursInAnyFrame) {
  for (const MergeOptions& options : {kMean, kFirst}) {
    PlaceGraphBuilder builder(townLabels(), options);
    // road and building, then the same building and a pole; the car is seen alone
    builder.addImageBlobs({blobAt(kRoad, 0, 0, 0), blobAt(kBuilding, 10, 20, 0)}, {{0, 1}}, 0);
    builder.addImageBlobs(
        {blobAt(kPole, 30, 0, 0), blobAt(kBuilding, 11, 20, 0), blobAt(kCar, 90, 0, 0)}, {{0, 1}},
        1);
    const SemanticGraph graph = builder.graph();
    EXPECT_TRUE(isConsistent(graph));
    EXPECT_EQ(graph.space, GraphSpace::image);
    ASSERT_EQ(graph.size(), 4u);
    EXPECT_EQ(graph.vertices[1].label, kBuilding);
    EXPECT_EQ(graph.edgeCount(), 2u);
    EXPECT_EQ(graph.neighbours[1].size(), 2u) << "the building knows both";
  }
}

TEST(ImageGraph, SurfacesStayWhereTheyWereFirstSeenAndAreSpaced) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  for (int frame = 0; frame <= 50; ++frame)
    builder.addImageBlobs({blobAt(kRoad, frame, 0, 0)}, {}, frame);
  const SemanticGraph graph = builder.graph();
  ASSERT_EQ(graph.size(), 5u);
  for (std::size_t i = 0; i < graph.size(); ++i)
    EXPECT_EQ(graph.vertices[i].position.x(), 11.0 * static_cast<double>(i));
}

TEST(ImageGraph, ObjectsMoveToTheirMean) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.addImageBlobs({blobAt(kPole, 0, 0, 0)}, {}, 0);
  builder.addImageBlobs({blobAt(kPole, 1, 0, 0)}, {}, 1);
  ASSERT_EQ(builder.graph().size(), 1u);
  EXPECT_NEAR(builder.graph().vertices[0].position.x(), 0.5, 1e-12);
}

TEST(ImageGraph, EdgesOfIgnoredBlobsAreLeftOut) {
  PlaceGraphBuilder builder(townLabels(), kMean);
  builder.addImageBlobs({blobAt(kSky, 0, 0, 0), blobAt(kPole, 5, 0, 0), blobAt(kCar, 50, 0, 0),
                         blobAt(kRoad, 0, 0, 0)},
                        {{0, 1}, {1, 2}, {1, 3}}, 0);
  builder.addImageBlobs({blobAt(kPole, 5, 0, 0), blobAt(kRoad, 0, 0, 0)}, {}, 1);
  const SemanticGraph graph = builder.graph();
  ASSERT_EQ(graph.size(), 3u);
  EXPECT_EQ(graph.edgeCount(), 2u);
}

TEST(ImageGraph, BlobsThatMergeHaveNoEdgeToThemselves) {
  PlaceGraphBuilder builder(townLabels(), kFirst);
  builder.addImageBlobs({blobAt(kRoad, 0, 0, 0), blobAt(kRoad, 4, 0, 0)}, {{0, 1}}, 0);
  EXPECT_EQ(builder.graph().size(), 1u);
  EXPECT_EQ(builder.graph().edgeCount(), 0u);
}

}  // namespace
}  // namespace xview
