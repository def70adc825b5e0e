// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "support/test_data.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

TEST(RecordedData, SuburbOpensWithItsFramesPosesAndClasses) {
  XVIEW_REQUIRE_DATA(data, "suburb_clean");
  const auto source = openRecording(data + "/forward");
  ASSERT_EQ(source->size(), 121u);
  EXPECT_EQ(source->labels().classes().size(), 15u);
  EXPECT_EQ(source->labels().kind(7), Kind::pole);
  EXPECT_EQ(source->labels().role(0), Role::ignored);
  EXPECT_EQ(source->labels().role(8), Role::dynamic);
  EXPECT_NEAR(source->pose(0).translation().x(), -56.836742, 1e-9);
  EXPECT_NEAR(source->stamp(1) - source->stamp(0), 0.222222, 1e-6);
  const Frame frame = source->read(120);
  EXPECT_EQ(frame.number, 120);
  EXPECT_EQ(frame.depth.width, 320);
  EXPECT_EQ(frame.instance.height, 240);
  float farthest = 0;
  for (const float depth : frame.depth.pixels) farthest = std::max(farthest, depth);
  EXPECT_GT(farthest, 10);
  EXPECT_LT(farthest, 656);
}

TEST(RecordedData, EverySuburbSessionOpens) {
  for (const char* world : {"suburb_clean", "suburb_noisy"}) {
    XVIEW_REQUIRE_DATA(data, world);
    for (const char* session : {"forward", "rear", "oblique", "aerial", "forward2", "elsewhere"}) {
      const auto source = openRecording(data + "/" + session);
      EXPECT_GE(source->size(), 61u) << session;
      EXPECT_NO_THROW(source->read(source->size() - 1)) << session;
    }
  }
}

TEST(RecordedData, KittiMapQueryAndNegativeOpen) {
  XVIEW_REQUIRE_DATA(data, "kitti00");
  const auto map = openRecording(data + "/map");
  ASSERT_EQ(map->size(), 24u);
  EXPECT_EQ(map->labels().name(), "semantic_kitti");
  EXPECT_EQ(map->number(23), 88);
  EXPECT_LT(map->pose(0).translation().norm(), 1e-3);
  EXPECT_NEAR(map->pose(2).translation().x(), 1.38, 0.02);  // forward is x of the velodyne
  EXPECT_GT(map->read(22).cloud.size(), 100000u);
  for (const char* other : {"/query_4501", "/negative_850"}) {
    const auto source = openRecording(data + other);
    EXPECT_EQ(source->size(), 1u);
    EXPECT_LT((source->pose(0).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-3);
  }
}

TEST(RecordedData, NuscenesScansHaveTheirOwnClasses) {
  XVIEW_REQUIRE_DATA(data, "nuscenes32");
  const auto source = openRecording(data);
  EXPECT_EQ(source->size(), 32u);
  EXPECT_EQ(source->labels().className(3), "pole");
  EXPECT_EQ(source->labels().role(10), Role::ignored);
}

TEST(RecordedData, BareObjectMapsAreGraphsAndClustersAreClouds) {
  XVIEW_REQUIRE_DATA(data, "");
  for (const char* graph : {"osm/monaco_2012-07-06.ply", "osm/monaco_2020-07-19.ply",
                            "osm/andorra_2020-05-01.ply", "osm/andorra_2021-10-28.ply",
                            "pole_maps/poles_nclt_auto.ply", "pole_maps/poles_nclt_gt.ply"}) {
    EXPECT_EQ(recogniseInput(data + graph), InputKind::graph) << graph;
  }
  EXPECT_EQ(recogniseInput(data + "mosd/learn0.pcd"), InputKind::cloud);
  EXPECT_EQ(openRecording(data + "mosd/learn0.pcd")->labels().classes().size(), 3u);
}

}  // namespace
}  // namespace xview::io
