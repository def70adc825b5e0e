// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/semantic_place.h"

#include <gtest/gtest.h>

#include "xview/base/error.h"

namespace xview {
namespace {

TEST(PlaceSizes, WordsAndSpacingsAreReadBack) {
  EXPECT_FALSE(parseSize("auto"));
  EXPECT_EQ(parseSize("town"), 1);
  EXPECT_GT(*parseSize("town"), *parseSize("room"));
  EXPECT_GT(*parseSize("room"), *parseSize("desk"));
  for (const char* text : {"town", "room", "desk", "0.02", "0.7", "2", "300"}) {
    const double size = *parseSize(text);
    EXPECT_EQ(parseSize(sizeText(size)), size) << text;
  }
}

TEST(PlaceSizes, ASpacingIsThatOfThings) {
  EXPECT_EQ(parseSize("4"), kTownScale);
  EXPECT_EQ(parseSize("0.9"), kRoomScale);
  EXPECT_EQ(parseSize("0.25"), kDeskScale);
}

TEST(PlaceSizes, AnythingElseIsMisuse) {
  for (const char* text : {"house", "-1", "0", "nan", "1e9", "2m"})
    EXPECT_THROW(parseSize(text), UsageError) << text;
}

TEST(PlaceSizes, ScalingThereAndBackChangesNoDigit) {
  Place place;
  Vertex vertex;
  vertex.position = {1.1, -2.3, 0.7};
  vertex.extent = {0.1, 0.2, 0.3};
  vertex.sigma_m = 0.013;
  place.graph.vertices = {vertex};
  place.cloud.origin = {1e5 + 0.1, 3.3, -7.7};
  place.cloud.points.push_back(Point(0.1f, 0.7f, -0.3f, 3));
  place.bev[BevChannel::pole] = {{0.3f, 0.9f, 1.1f}};
  place.poses = {Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.2, 0.3))};
  Place there = place;
  scaleLengths(1 / kDeskScale, there);
  EXPECT_EQ(there.graph.vertices[0].position, 16 * vertex.position);
  EXPECT_EQ(there.bev.cell_m, 16 * place.bev.cell_m);
  scaleLengths(kDeskScale, there);
  EXPECT_EQ(there.graph.vertices[0].position, vertex.position);
  EXPECT_EQ(there.graph.vertices[0].extent, vertex.extent);
  EXPECT_EQ(there.graph.vertices[0].sigma_m, vertex.sigma_m);
  EXPECT_EQ(there.cloud.position(0), place.cloud.position(0));
  EXPECT_EQ(there.bev[BevChannel::pole][0].z, place.bev[BevChannel::pole][0].z);
  EXPECT_EQ(there.poses[0].translation(), place.poses[0].translation());
}

}  // namespace
}  // namespace xview
