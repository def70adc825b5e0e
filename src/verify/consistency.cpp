// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/consistency.h"

#include <algorithm>

#include "verify/distance_agreement.h"

namespace xview::verify {
namespace {

/// Coordinates of the taking part correspondences, one array each, so that the inner loop is plain
/// arithmetic over rows.
struct Columns {
  std::vector<double> qx, qy, qz, mx, my, mz;
  std::vector<std::uint32_t> query, map, node;
};

/// Indices of the most similar correspondences of finite positions, in their own order.
std::vector<std::uint32_t> mostSimilar(const std::vector<Eigen::Vector3d>& query,
                                       const std::vector<Eigen::Vector3d>& map,
                                       const std::vector<Correspondence>& correspondences,
                                       std::size_t limit) {
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < correspondences.size(); ++i) {
    const Correspondence& c = correspondences[i];
    if (query[c.query].allFinite() && map[c.map].allFinite()) kept.push_back(i);
  }
  if (kept.size() <= limit) return kept;
  std::nth_element(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(limit), kept.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float sa = correspondences[a].similarity;
                     const float sb = correspondences[b].similarity;
                     return sa != sb ? sa > sb : a < b;
                   });
  kept.resize(limit);
  std::sort(kept.begin(), kept.end());
  return kept;
}

Columns columnsOf(const std::vector<Eigen::Vector3d>& query,
                  const std::vector<Eigen::Vector3d>& map,
                  const std::vector<Correspondence>& correspondences, std::size_t limit) {
  Columns c;
  for (const std::uint32_t i : mostSimilar(query, map, correspondences, limit)) {
    const Eigen::Vector3d& q = query[correspondences[i].query];
    const Eigen::Vector3d& m = map[correspondences[i].map];
    c.qx.push_back(q.x());
    c.qy.push_back(q.y());
    c.qz.push_back(q.z());
    c.mx.push_back(m.x());
    c.my.push_back(m.y());
    c.mz.push_back(m.z());
    c.query.push_back(correspondences[i].query);
    c.map.push_back(correspondences[i].map);
    c.node.push_back(i);
  }
  return c;
}

/// agree[b] = 1 for each b < a whose pair distances to a agree.
}  // namespace

ConsistencyGraph::ConsistencyGraph(std::size_t nodes)
    : nodes_(nodes), words_((nodes + 63) / 64), bits_(nodes * words_, 0) {}

void ConsistencyGraph::connect(std::uint32_t a, std::uint32_t b) {
  bits_[a * words_ + b / 64] |= std::uint64_t{1} << (b % 64);
  bits_[b * words_ + a / 64] |= std::uint64_t{1} << (a % 64);
}

bool ConsistencyGraph::connected(std::uint32_t a, std::uint32_t b) const {
  return (row(a)[b / 64] >> (b % 64) & 1) != 0;
}

std::uint32_t ConsistencyGraph::degree(std::uint32_t node) const {
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < words_; ++w) {
    count += static_cast<std::uint32_t>(__builtin_popcountll(row(node)[w]));
  }
  return count;
}

ConsistencyGraph pairwiseConsistency(const std::vector<Eigen::Vector3d>& query,
                                     const std::vector<Eigen::Vector3d>& map,
                                     const std::vector<Correspondence>& correspondences,
                                     const ConsistencyOptions& options) {
  ConsistencyGraph graph(correspondences.size());
  const Columns c =
      columnsOf(query, map, correspondences, static_cast<std::size_t>(options.max_correspondences));
  std::vector<std::uint8_t> agree(c.node.size());
  std::vector<double> in_query(c.node.size()), in_map(c.node.size());
  for (std::size_t a = 0; a < c.node.size(); ++a) {
    distancesToEarlier({c.qx.data(), c.qy.data(), c.qz.data()}, a, in_query.data());
    distancesToEarlier({c.mx.data(), c.my.data(), c.mz.data()}, a, in_map.data());
    compareDistances(in_query.data(), in_map.data(), a, options.tolerance_m, options.relative,
                     options.min_separation_m, agree.data());
    for (std::size_t b = 0; b < a; ++b) {
      if (agree[b] && c.query[a] != c.query[b] && c.map[a] != c.map[b]) {
        graph.connect(c.node[a], c.node[b]);
      }
    }
  }
  return graph;
}

}  // namespace xview::verify
