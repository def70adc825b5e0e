// SPDX-License-Identifier: BSD-3-Clause
#include "cluster_overlap.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace xview::bench {
namespace {

using Pair = std::pair<std::uint32_t, int>;  // object, cluster

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? std::numeric_limits<double>::quiet_NaN()
                    : static_cast<double>(part) / static_cast<double>(whole);
}

/// Points of each object, of each cluster, and of both together.
struct Counts {
  std::map<std::uint32_t, std::size_t> objects;
  std::map<int, std::size_t> clusters;
  std::map<Pair, std::size_t> common;

  double overlap(const Pair& pair, std::size_t points) const {
    return ratio(points, objects.at(pair.first) + clusters.at(pair.second) - points);
  }
};

Counts countPoints(const std::vector<std::uint32_t>& objects, const std::vector<int>& clusters,
                   const OverlapRule& rule) {
  Counts counts;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const bool is_object = objects[i] != rule.no_object, is_clustered = clusters[i] >= 0;
    if (!is_object && rule.ignore_background) continue;
    if (is_object) ++counts.objects[objects[i]];
    if (is_clustered) ++counts.clusters[clusters[i]];
    if (is_object && is_clustered) ++counts.common[{objects[i], clusters[i]}];
  }
  return counts;
}

}  // namespace

double ClusterScore::precision() const { return ratio(matched, clusters); }
double ClusterScore::recall() const { return ratio(matched, objects); }

ClusterScore scoreClusters(const std::vector<std::uint32_t>& object_of_point,
                           const std::vector<int>& cluster_of_point, const OverlapRule& rule) {
  if (object_of_point.size() != cluster_of_point.size())
    throw std::invalid_argument("objects and clusters are of different numbers of points");
  const Counts counts = countPoints(object_of_point, cluster_of_point, rule);
  std::vector<std::pair<double, Pair>> pairs;
  for (const auto& [pair, points] : counts.common) {
    const double overlap = counts.overlap(pair, points);
    if (overlap > rule.min_overlap) pairs.emplace_back(-overlap, pair);  // the best comes first
  }
  std::sort(pairs.begin(), pairs.end());

  ClusterScore score;
  score.objects = counts.objects.size();
  score.clusters = counts.clusters.size();
  std::set<std::uint32_t> taken_objects;
  std::set<int> taken_clusters;
  double sum = 0;
  for (const auto& [negative_overlap, pair] : pairs) {
    if (taken_objects.count(pair.first) || taken_clusters.count(pair.second)) continue;
    taken_objects.insert(pair.first);
    taken_clusters.insert(pair.second);
    sum -= negative_overlap;
  }
  score.matched = taken_objects.size();
  score.mean_overlap = score.matched == 0 ? std::numeric_limits<double>::quiet_NaN()
                                          : sum / static_cast<double>(score.matched);
  return score;
}

}  // namespace xview::bench
