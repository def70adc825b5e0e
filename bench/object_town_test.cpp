// SPDX-License-Identifier: BSD-3-Clause
#include "object_town.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "xview/types/error.h"
#include "xview/types/pose.h"

namespace xview::bench {
namespace {

bool areEqual(const SemanticGraph& a, const SemanticGraph& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a.vertices[i].label != b.vertices[i].label ||
        a.vertices[i].position != b.vertices[i].position)
      return false;
  }
  return true;
}

double nearest(const SemanticGraph& graph, std::uint32_t label, const Eigen::Vector2d& p) {
  double best = 1e9;
  for (const Vertex& v : graph.vertices) {
    if (v.label == label) best = std::min(best, (v.position.head<2>() - p).norm());
  }
  return best;
}

TEST(ObjectTown, SameSeedSameTown) {
  const ObjectTown a(5, 3), b(5, 3), other(5, 4);
  ASSERT_EQ(a.objects().size(), b.objects().size());
  EXPECT_TRUE(areEqual(mapObjectTown(a, TownNoise::medium(), {}, 1),
                       mapObjectTown(b, TownNoise::medium(), {}, 1)));
  EXPECT_FALSE(areEqual(mapObjectTown(a, TownNoise::medium(), {}, 1),
                        mapObjectTown(other, TownNoise::medium(), {}, 1)));
  EXPECT_FALSE(areEqual(mapObjectTown(a, TownNoise::medium(), {}, 1),
                        mapObjectTown(a, TownNoise::medium(), {}, 2)));
  const TownQuery q = queryObjectTown(a, TownNoise::noisy(), {}, TownView::rear, 60, 5);
  EXPECT_TRUE(
      areEqual(q.graph, queryObjectTown(b, TownNoise::noisy(), {}, TownView::rear, 60, 5).graph));
}

TEST(ObjectTown, HasAllClassesAndTheWantedDensity) {
  const ObjectTown town(8, 1);
  const SemanticGraph map = mapObjectTown(town, TownNoise::medium(), {10, 2}, 1);
  EXPECT_TRUE(isConsistent(map));
  std::array<int, 9> count{};
  for (const Vertex& v : map.vertices) ++count.at(v.label);
  for (std::uint32_t label = 1; label <= 8; ++label) {
    EXPECT_GT(count[label], static_cast<int>(map.size() / 50)) << label;
    EXPECT_NE(objectTownLabels().find(label), nullptr);
  }
  const double per_km = static_cast<double>(map.size()) / (town.streetLength() / 1000);
  EXPECT_GT(per_km, 350);
  EXPECT_LT(per_km, 600);
}

TEST(ObjectTown, ObjectsNearAreThoseOfBruteForce) {
  const ObjectTown town(4, 2);
  std::vector<std::uint32_t> found;
  town.objectsNear(120, 90, 40, found);
  const std::set<std::uint32_t> set(found.begin(), found.end());
  EXPECT_EQ(set.size(), found.size());
  for (std::uint32_t i = 0; i < town.objects().size(); ++i) {
    const TownObject& o = town.objects()[i];
    const bool is_near = std::abs(o.x - 120) <= 40 && std::abs(o.y - 90) <= 40;
    EXPECT_TRUE(!is_near || set.count(i) == 1) << i;
  }
}

TEST(ObjectTown, TrueQueryPoseBringsThePerfectQueryOntoTheMap) {
  const ObjectTown town(6, 5);
  const TownNoise exact{0, 0, 0.05, 0, 0, 0};
  const SemanticGraph map = mapObjectTown(town, exact, {}, 1);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const TownQuery q = queryObjectTown(town, exact, {}, TownView::rear, 60, seed);
    EXPECT_LT((q.T_map_query * q.last_in_query - q.last_in_map).head<2>().norm(), 0.1);
    int trees = 0, hits = 0;
    for (const Vertex& v : q.graph.vertices) {
      if (v.label != static_cast<std::uint32_t>(TownClass::tree)) continue;
      ++trees;
      hits += nearest(map, v.label, (q.T_map_query * v.position).head<2>()) < 0.5;
    }
    EXPECT_GE(hits, 0.8 * trees);
  }
}

TEST(ObjectTown, NothingThinIsSeenFromTheAir) {
  const ObjectTown town(6, 6);
  const TownNoise exact{0, 0, 0.1, 0, 0, 0};
  const TownQuery q = queryObjectTown(town, exact, {}, TownView::aerial, 100, 1);
  ASSERT_GT(q.graph.size(), 20u);
  for (const Vertex& v : q.graph.vertices) {
    EXPECT_NE(v.label, static_cast<std::uint32_t>(TownClass::pole));
    EXPECT_NE(v.label, static_cast<std::uint32_t>(TownClass::sign));
  }
}

TEST(ObjectTown, LengthsThatAreMultiplesOfTheStepEnd) {
  const ObjectTown town(3, 7);
  for (const double length : {0.0, 2.0, 60.0, 1000.0}) {
    const TownQuery q =
        queryObjectTown(town, TownNoise::perfect(), {}, TownView::forward, length, 1);
    EXPECT_TRUE(q.T_map_query.matrix().allFinite());
    EXPECT_TRUE(q.last_in_map.allFinite());
  }
}

TEST(ObjectTown, ImpossibleSizesAreRefused) {
  EXPECT_THROW(ObjectTown(1, 1), UsageError);
  EXPECT_THROW(ObjectTown(100000, 1), UsageError);
}

}  // namespace
}  // namespace xview::bench
