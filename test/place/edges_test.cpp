// SPDX-License-Identifier: BSD-3-Clause
#include "place/edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "scenes.h"

namespace xview {

namespace {

using namespace test;
using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

SemanticGraph graphAt(const std::vector<Eigen::Vector3d>& positions) {
  SemanticGraph graph;
  for (const Eigen::Vector3d& p : positions) {
    Vertex vertex;
    vertex.position = p;
    graph.vertices.push_back(vertex);
  }
  graph.neighbours.resize(positions.size());
  return graph;
}

Edges connected(const std::vector<Eigen::Vector3d>& positions, double radius_m, int nearest = 0) {
  SemanticGraph graph = graphAt(positions);
  EdgeOptions options;
  options.radius_m = radius_m;
  connectByRadius(graph, options, nearest);
  EXPECT_TRUE(isConsistent(graph));
  return graph.edges();
}

Edges allPairsWithin(const std::vector<Eigen::Vector3d>& positions, double radius_m) {
  Edges edges;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    for (std::uint32_t j = i + 1; j < positions.size(); ++j) {
      if ((positions[i] - positions[j]).norm() <= radius_m) edges.emplace_back(i, j);
    }
  }
  return edges;
}

std::vector<Eigen::Vector3d> scattered(std::size_t count, double extent_m, Random& random) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < count; ++i) {
    positions.emplace_back(random.uniform(-extent_m, extent_m), random.uniform(-extent_m, extent_m),
                           random.uniform(-3, 3));
  }
  return positions;
}

TEST(Edges, AreAllPairsWithinTheRadius) {
  Random random(1);
  for (const std::size_t count : {2u, 10u, 100u, 400u}) {
    const auto positions = scattered(count, 60, random);
    EXPECT_EQ(connected(positions, 15), allPairsWithin(positions, 15));
  }
}

TEST(Edges, JoinTheNearestOfEitherWithinTheRadius) {
  Random random(4);
  const auto positions = scattered(200, 60, random);
  std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    std::vector<std::pair<double, std::uint32_t>> others;
    for (std::uint32_t j = 0; j < positions.size(); ++j)
      if (j != i) others.emplace_back((positions[i] - positions[j]).norm(), j);
    std::sort(others.begin(), others.end());
    for (std::size_t k = 0; k < 4 && others[k].first <= 12; ++k)
      expected.insert(std::minmax(i, others[k].second));
  }
  EXPECT_EQ(connected(positions, 12, 4), Edges(expected.begin(), expected.end()));
  EXPECT_EQ(connected(positions, 12, 199), allPairsWithin(positions, 12));
}

TEST(Edges, IncludeTheRadiusItselfAtMapProjectionCoordinates) {
  std::vector<Eigen::Vector3d> lattice;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) lattice.emplace_back(500000 + 15 * x, 4649776 + 15 * y, 0);
  }
  EXPECT_EQ(connected(lattice, 15).size(), 60u);
}

TEST(Edges, AreFoundWhereSinglePrecisionIsCoarse) {
  // Two towns 400 km apart: after centring, floats are 16 mm apart.
  Random random(4);
  std::vector<Eigen::Vector3d> pairs;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p((i % 2 ? -2e5 : 2e5) + 100 * i + random.uniform(0, 1), 0, 0);
    pairs.push_back(p);
    pairs.push_back(p + Eigen::Vector3d(15.0049, 0, 0));
  }
  EXPECT_EQ(connected(pairs, 15.005).size(), 100u);
}

TEST(Edges, DoNotDependOnTheFrame) {
  Random random(2);
  const auto positions = scattered(200, 60, random);
  const Eigen::Isometry3d T = randomPose(random);
  std::vector<Eigen::Vector3d> moved;
  for (const Eigen::Vector3d& p : positions) moved.push_back(T * p);
  EXPECT_EQ(connected(moved, 15), connected(positions, 15));
}

TEST(Edges, FollowTheVerticesWhenTheyAreRenumbered) {
  Random random(3);
  const auto positions = scattered(150, 60, random);
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  std::vector<Eigen::Vector3d> renumbered;
  for (const std::uint32_t i : order) renumbered.push_back(positions[i]);
  Edges back;
  for (const auto& [a, b] : connected(renumbered, 15)) {
    back.push_back(std::minmax(order[a], order[b]));
  }
  std::sort(back.begin(), back.end());
  EXPECT_EQ(back, connected(positions, 15));
}

/// What countEdges() says, and that making the edges gives the same.
EdgeCount counted(const std::vector<Eigen::Vector3d>& positions, double radius_m) {
  SemanticGraph graph = graphAt(positions);
  useRadius(graph, {radius_m});
  const EdgeCount count = countEdges(graph);
  makeEdges(graph);
  EXPECT_EQ(count.edges, graph.edgeCount());
  EXPECT_EQ(count.parts, componentCount(graph));
  const EdgeCount of_made = countEdges(graph);
  EXPECT_EQ(of_made.edges, count.edges);
  EXPECT_EQ(of_made.parts, count.parts);
  return count;
}

TEST(Edges, AreCountedWithoutMakingThem) {
  Random random(6);
  for (const double radius_m : {3.0, 8.0, 15.0, 500.0}) {
    const EdgeCount count = counted(scattered(400, 60, random), radius_m);
    EXPECT_GT(count.edges, 0u);
    EXPECT_EQ(count.parts == 1, radius_m >= 15) << radius_m;
  }
  std::vector<Eigen::Vector3d> positions = scattered(50, 20, random);
  positions.push_back(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  positions.emplace_back(1e12, 0, 0);
  positions.emplace_back(1e12, 5, 0);
  EXPECT_EQ(counted(positions, 40).parts, 3u);
  const double east = 4.6e6, north = 5.4e6;  // neighbours on a border of cells, a radius apart
  std::vector<Eigen::Vector3d> row;
  for (int i = 0; i < 200; ++i) row.emplace_back(east + 0.7 * i, north - 0.7 * i, 0);
  EXPECT_EQ(counted(row, 0.7 * std::sqrt(2.0) + 1e-9).edges, 199u);
  EXPECT_EQ(counted({}, 15).parts, 0u);
}

TEST(Edges, OfEmptySingleAndFarVerticesAreNone) {
  EXPECT_TRUE(connected({}, 15).empty());
  EXPECT_TRUE(connected({{1, 2, 3}}, 15).empty());
  EXPECT_TRUE(connected({{0, 0, 0}, {1e7, 0, 0}, {0, -1e7, 0}}, 15).empty());
}

TEST(Edges, JoinVerticesAtTheSamePlace) {
  EXPECT_EQ(connected({{5, 5, 5}, {5, 5, 5}, {5, 5, 5}}, 1).size(), 3u);
}

TEST(Edges, LeaveVerticesWithoutAFinitePositionAlone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(connected({{0, 0, 0}, {nan, 0, 0}, {1, 0, 0}}, 15), (Edges{{0, 2}}));
  EXPECT_TRUE(connected({{nan, 0, 0}, {nan, 0, 0}}, 15).empty());
}

TEST(Edges, ReplaceThoseOfBefore) {
  SemanticGraph graph = graphAt({{0, 0, 0}, {100, 0, 0}, {101, 0, 0}});
  graph.setEdges({{0, 1}});
  connectByRadius(graph, {});
  EXPECT_EQ(graph.edges(), (Edges{{1, 2}}));
}

}  // namespace
}  // namespace xview
