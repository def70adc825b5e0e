// SPDX-License-Identifier: BSD-3-Clause
#include "place/merge.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"

namespace xview {

namespace {

constexpr std::uint32_t kPole = 3, kSign = 5, kHouse = 7;

LabelSet streetLabels() {
  return test::labelSetOf("street", {{kPole, "pole", Role::object, Kind::pole},
                                     {kSign, "sign", Role::object, Kind::sign},
                                     {kHouse, "house", Role::surface, Kind::building}});
}

Vertex vertexAt(std::uint32_t label, double x, double y, double z) {
  Vertex v;
  v.label = label;
  v.position = {x, y, z};
  v.extent = {.2, .3, 4};
  v.observations = 9;
  v.points = 70;
  v.sigma_m = .1;
  return v;
}

/// A BEV grid that saw something, with its origin at (128, 64, 2).
BevGrid streetBev() {
  BevGrid bev;
  bev.origin_x = 128;
  bev.origin_y = 64;
  bev.origin_z = 2;
  bev.known.push_back({0, 0, 0, true});
  return bev;
}

SemanticGraph graphOf(std::vector<Vertex> vertices) {
  SemanticGraph graph;
  graph.vertices = std::move(vertices);
  graph.neighbours.resize(graph.size());
  return graph;
}

TEST(ThinObjects, StandWithTheirFootAtThePeakAndKeepWhatTheClusterTold) {
  BevGrid bev = streetBev();
  bev[BevChannel::pole] = bev[BevChannel::pole_like] = {{10, 5, -.5f}};
  SemanticGraph graph = graphOf({vertexAt(kPole, 138.7, 69.6, 4), vertexAt(kHouse, 140, 70, 3)});
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 2u);
  EXPECT_TRUE(isConsistent(graph));
  EXPECT_EQ(graph.vertices[0].label, kHouse);
  EXPECT_EQ(graph.vertices[0].position, Eigen::Vector3d(140, 70, 3));
  const Vertex& pole = graph.vertices[1];
  EXPECT_EQ(pole.label, kPole);
  EXPECT_EQ(pole.position, Eigen::Vector3d(138, 69, 1.5));
  EXPECT_EQ(pole.observations, 9u);
  EXPECT_EQ(pole.points, 70u);
}

TEST(ThinObjects, WithoutAPeakGo) {
  SemanticGraph graph = graphOf({vertexAt(kPole, 138, 69, 4), vertexAt(kSign, 150, 69, 4)});
  placeThinObjects(graph, streetBev(), streetLabels());
  EXPECT_TRUE(graph.empty());
}

TEST(ThinObjects, WithoutAClusterAreNew) {
  BevGrid bev = streetBev();
  bev[BevChannel::sign] = bev[BevChannel::pole_like] = {{10, 5, 0}};
  SemanticGraph graph = graphOf({vertexAt(kSign, 145, 69, 4)});
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 1u);
  EXPECT_EQ(graph.vertices[0].label, kSign);
  EXPECT_EQ(graph.vertices[0].observations, 1u) << "the cluster 7 m away is another thing";
}

TEST(ThinObjects, OfNoLabelArePoles) {
  BevGrid bev = streetBev();
  bev[BevChannel::pole_like] = {{20, 5, 0}};
  bev[BevChannel::obstacle_low] = {{20.25f, 5.25f, 0}};
  SemanticGraph graph;
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 1u);
  EXPECT_EQ(graph.vertices[0].label, kPole);
  EXPECT_EQ(graph.vertices[0].position, Eigen::Vector3d(148, 69, 2));
}

TEST(ThinObjects, ThatStandBelowASignArePolesBesideIt) {
  BevGrid bev = streetBev();
  bev[BevChannel::sign] = {{10, 5, 0}, {30, 5, 0}};
  bev[BevChannel::pole_like] = {{10.3f, 5, 0}, {30, 5, 0}};
  bev[BevChannel::obstacle_low] = {{10.25f, 5.25f, 0}, {32.25f, 5.25f, 0}};
  SemanticGraph graph;
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 3u) << "below the second sign nothing stands";
  EXPECT_EQ(graph.vertices[0].label, kPole);
  EXPECT_NEAR(graph.vertices[0].position.x(), 138.3, 1e-6);
  EXPECT_EQ(graph.vertices[1].label, kSign);
  EXPECT_EQ(graph.vertices[2].label, kSign);
}

TEST(ThinObjects, OfAPoleAreWhereAllItsLabelsPutThem) {
  BevGrid bev = streetBev();
  bev[BevChannel::pole] = {{10.4f, 5, 0}};
  bev[BevChannel::pole_like] = {{10, 5, 0}};
  SemanticGraph graph = graphOf({vertexAt(kPole, 138.7, 69.6, 4)});
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 1u);
  EXPECT_EQ(graph.vertices[0].position, Eigen::Vector3d(138, 69, 2));
}

TEST(ThinObjects, OfKindsWithoutAClassAreLeftOut) {
  BevGrid bev = streetBev();
  bev[BevChannel::light] = {{10, 5, 0}};
  SemanticGraph graph;
  placeThinObjects(graph, bev, streetLabels());
  EXPECT_TRUE(graph.empty());
}

TEST(ThinObjects, ArePlacedInTheFrameOfTheGraphIfThatIsTilted) {
  BevGrid bev = streetBev();
  bev.alignment = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  bev[BevChannel::pole] = bev[BevChannel::pole_like] = {{10, 5, 1}};
  const Eigen::Vector3d p_frame = bev.alignment.conjugate() * Eigen::Vector3d(138, 69, 3);
  SemanticGraph graph = graphOf({vertexAt(kPole, p_frame.x(), p_frame.y(), p_frame.z())});
  graph.vertices[0].position += bev.alignment.conjugate() * Eigen::Vector3d(.5, 0, 3);
  placeThinObjects(graph, bev, streetLabels());
  ASSERT_EQ(graph.size(), 1u);
  EXPECT_LT((graph.vertices[0].position - p_frame).norm(), 1e-6);
  EXPECT_EQ(graph.vertices[0].points, 70u);
}

TEST(ThinObjects, StayAsTheyAreWithoutABevGrid) {
  SemanticGraph graph = graphOf({vertexAt(kPole, 138, 69, 4), vertexAt(kPole, 139, 69, 4)});
  graph.setEdges({{0, 1}});
  placeThinObjects(graph, BevGrid(), streetLabels());
  EXPECT_EQ(graph.size(), 2u);
  EXPECT_EQ(graph.edgeCount(), 1u);
}

}  // namespace
}  // namespace xview
