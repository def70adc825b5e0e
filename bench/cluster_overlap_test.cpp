// SPDX-License-Identifier: BSD-3-Clause
#include "cluster_overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "xview/types/random.h"

namespace xview::bench {
namespace {

TEST(ClusterOverlap, OfTheObjectsThemselvesIsPerfect) {
  const ClusterScore score = scoreClusters({1, 1, 2, 2, 0}, {4, 4, 9, 9, -1}, {});
  EXPECT_EQ(score.objects, 2u);
  EXPECT_DOUBLE_EQ(score.precision(), 1);
  EXPECT_DOUBLE_EQ(score.recall(), 1);
  EXPECT_DOUBLE_EQ(score.mean_overlap, 1);
}

TEST(ClusterOverlap, TwoObjectsInOneClusterAreAtMostOne) {
  const ClusterScore score = scoreClusters({1, 1, 1, 2}, {0, 0, 0, 0}, {});
  EXPECT_EQ(score.matched, 1u);
  EXPECT_DOUBLE_EQ(score.precision(), 1);
  EXPECT_DOUBLE_EQ(score.recall(), 0.5);
  EXPECT_DOUBLE_EQ(score.mean_overlap, 0.75);
}

TEST(ClusterOverlap, AnObjectCutInHalvesIsNotFound) {
  const ClusterScore score = scoreClusters({1, 1, 1, 1}, {0, 0, 1, 1}, {});
  EXPECT_EQ(score.matched, 0u) << "half is not more than half";
  EXPECT_DOUBLE_EQ(score.precision(), 0);
  EXPECT_TRUE(std::isnan(score.mean_overlap));
}

TEST(ClusterOverlap, BackgroundInAClusterCountsUnlessIgnored) {
  const std::vector<std::uint32_t> objects{1, 1, 0, 0, 0, 0};
  const std::vector<int> clusters{0, 0, 0, 0, 0, 1};
  const ClusterScore strict = scoreClusters(objects, clusters, {});
  EXPECT_EQ(strict.matched, 0u);
  EXPECT_EQ(strict.clusters, 2u);
  const ClusterScore lenient = scoreClusters(objects, clusters, {0.5, 0, true});
  EXPECT_EQ(lenient.matched, 1u);
  EXPECT_EQ(lenient.clusters, 1u);
}

TEST(ClusterOverlap, UsesEachClusterOnceTheBestFirst) {
  const ClusterScore score = scoreClusters({1, 1, 1, 2, 2}, {0, 0, 0, 0, 0}, {0.1, 0, false});
  EXPECT_EQ(score.matched, 1u);
  EXPECT_DOUBLE_EQ(score.mean_overlap, 0.6);
}

TEST(ClusterOverlap, OfNothingIsUnknown) {
  const ClusterScore score = scoreClusters({}, {}, {});
  EXPECT_TRUE(std::isnan(score.precision()));
  EXPECT_TRUE(std::isnan(score.recall()));
}

TEST(ClusterOverlap, OfDifferentPointsIsAnError) {
  EXPECT_THROW(scoreClusters({1}, {}, {}), std::invalid_argument);
}

TEST(ClusterOverlap, DoesNotDependOnNumbersOrOrder) {
  Random random(3);
  std::vector<std::uint32_t> objects, other_objects;
  std::vector<int> clusters, other_clusters;
  for (int i = 0; i < 500; ++i) {
    objects.push_back(random.below(6));
    clusters.push_back(random.uniform() < 0.7 ? static_cast<int>(objects.back())
                                              : static_cast<int>(random.below(7)) - 1);
  }
  for (std::size_t i = objects.size(); i-- > 0;) {
    other_objects.push_back(objects[i] == 0 ? 0 : 100 - objects[i]);
    other_clusters.push_back(clusters[i] < 0 ? -1 : 50 - clusters[i]);
  }
  const ClusterScore a = scoreClusters(objects, clusters, {}),
                     b = scoreClusters(other_objects, other_clusters, {});
  EXPECT_GT(a.matched, 0u);
  EXPECT_EQ(a.matched, b.matched);
  EXPECT_EQ(a.clusters, b.clusters);
  EXPECT_NEAR(a.mean_overlap, b.mean_overlap, 1e-12);
}

}  // namespace
}  // namespace xview::bench
