// SPDX-License-Identifier: BSD-3-Clause
#include "baselines/consistency_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace xview {
namespace {

constexpr std::size_t kGreedyPicksPerNode = 100;  // before the greedy start has tried enough

using Bits = std::vector<std::uint64_t>;

std::uint64_t bit(std::uint32_t i) { return std::uint64_t{1} << (i % 64); }

template <class Visit>
void forEachBit(const std::uint64_t* bits, std::size_t words, Visit visit) {
  for (std::size_t w = 0; w < words; ++w) {
    for (std::uint64_t rest = bits[w]; rest != 0; rest &= rest - 1) {
      visit(static_cast<std::uint32_t>(64 * w + static_cast<unsigned>(__builtin_ctzll(rest))));
    }
  }
}

/// Distances of a point to all before it; points in rows.
Eigen::ArrayXd distancesToEarlier(const Eigen::ArrayX3d& points, Eigen::Index at) {
  const auto squared = [&](Eigen::Index axis) {
    return (points.col(axis).head(at) - points(at, axis)).square();
  };
  return (squared(0) + squared(1) + squared(2)).sqrt();
}

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

/// Nodes by falling core number, the later-peeled of two equal ones first.
std::vector<std::uint32_t> densestFirst(const std::vector<std::uint32_t>& cores) {
  std::vector<std::uint32_t> order(cores.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return cores[a] > cores[b]; });
  return order;
}

/// The subgraph of `nodes`, renumbered in their order.
ConsistencyGraph induced(const ConsistencyGraph& graph, const std::vector<std::uint32_t>& nodes) {
  ConsistencyGraph result(nodes.size());
  std::vector<std::uint32_t> number(graph.size(), static_cast<std::uint32_t>(nodes.size()));
  for (std::uint32_t i = 0; i < nodes.size(); ++i) number[nodes[i]] = i;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    forEachBit(graph.row(nodes[i]), graph.words(), [&](std::uint32_t other) {
      if (number[other] < i) result.connect(i, number[other]);
    });
  }
  return result;
}

/// Grows a clique from `start`, always by the first node that fits.
std::vector<std::uint32_t> greedyClique(const ConsistencyGraph& graph, std::uint32_t start) {
  std::vector<std::uint32_t> clique{start};
  Bits candidates(graph.row(start), graph.row(start) + graph.words());
  for (std::size_t w = 0; w < candidates.size();) {
    if (candidates[w] == 0) {
      ++w;
      continue;
    }
    const auto node =
        static_cast<std::uint32_t>(64 * w + static_cast<unsigned>(__builtin_ctzll(candidates[w])));
    clique.push_back(node);
    const std::uint64_t* row = graph.row(node);
    for (std::size_t v = w; v < candidates.size(); ++v) candidates[v] &= row[v];
  }
  return clique;
}

std::vector<std::uint32_t> bestGreedyClique(const ConsistencyGraph& graph) {
  std::vector<std::uint32_t> best;
  std::size_t picked = 0;  // in all cliques so far
  for (std::uint32_t node = 0; node < graph.size(); ++node) {
    if (graph.degree(node) < best.size()) continue;
    auto clique = greedyClique(graph, node);
    picked += clique.size();
    if (clique.size() > best.size()) best = std::move(clique);
    if (picked > kGreedyPicksPerNode * graph.size()) break;
  }
  return best;
}

/// Branch and bound: nodes are branched in the order of a greedy colouring, whose number of colours
/// bounds the clique.
class CliqueSearch {
 public:
  CliqueSearch(const ConsistencyGraph& graph, std::vector<std::uint32_t> start, int budget)
      : graph_(graph), best_(std::move(start)), budget_(budget) {}

  /// Returns true if the result is proven.
  bool run() {
    Bits all(graph_.words(), 0);
    for (std::uint32_t i = 0; i < graph_.size(); ++i) all[i / 64] |= bit(i);
    expand(all);
    return budget_ >= 0;
  }

  const std::vector<std::uint32_t>& best() const { return best_; }

 private:
  struct Coloured {
    std::uint32_t node = 0;
    std::uint32_t colour =
        0;  // 1, 2, …: a clique up to here in the order has at most so many nodes
  };

  void expand(Bits& candidates) {
    if (--budget_ < 0) return;
    const std::vector<Coloured> order = colour(candidates);
    for (auto it = order.rbegin(); it != order.rend(); ++it) {
      if (clique_.size() + it->colour <= best_.size()) return;
      clique_.push_back(it->node);
      Bits common(candidates.size());
      const std::uint64_t* row = graph_.row(it->node);
      std::uint64_t any = 0;
      for (std::size_t w = 0; w < common.size(); ++w) any |= common[w] = candidates[w] & row[w];
      if (any != 0) {
        expand(common);
      } else if (clique_.size() > best_.size()) {
        best_ = clique_;
      }
      clique_.pop_back();
      if (budget_ < 0) return;
      candidates[it->node / 64] &= ~bit(it->node);
    }
  }

  /// Greedy colouring; nodes whose colour cannot lead beyond the best clique are left out.
  std::vector<Coloured> colour(const Bits& candidates) const {
    const std::size_t needed = best_.size() > clique_.size() ? best_.size() - clique_.size() : 0;
    std::vector<Coloured> order;
    Bits uncoloured = candidates, independent;
    std::size_t first = 0;
    for (std::uint32_t number = 1;; ++number) {
      while (first < uncoloured.size() && uncoloured[first] == 0) ++first;
      if (first == uncoloured.size()) return order;
      independent = uncoloured;
      for (std::size_t w = first; w < independent.size(); ++w) {
        while (independent[w] != 0) {
          const auto node = static_cast<std::uint32_t>(
              64 * w + static_cast<unsigned>(__builtin_ctzll(independent[w])));
          uncoloured[w] &= ~bit(node);
          independent[w] &= ~bit(node);
          const std::uint64_t* row = graph_.row(node);
          for (std::size_t v = w; v < independent.size(); ++v) independent[v] &= ~row[v];
          if (number > needed) order.push_back({node, number});
        }
      }
    }
  }

  const ConsistencyGraph& graph_;
  std::vector<std::uint32_t> best_, clique_;
  int budget_;
};

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
                                     const ConsistencyOptions& options, std::size_t most) {
  ConsistencyGraph graph(correspondences.size());
  const std::vector<std::uint32_t> nodes = mostSimilar(query, map, correspondences, most);
  const auto count = static_cast<Eigen::Index>(nodes.size());
  Eigen::ArrayX3d q(count, 3), m(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    q.row(i) = query[correspondences[nodes[i]].query];
    m.row(i) = map[correspondences[nodes[i]].map];
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const Correspondence& a = correspondences[nodes[i]];
    const Eigen::ArrayXd in_query = distancesToEarlier(q, i), in_map = distancesToEarlier(m, i);
    const Eigen::ArrayXd larger = in_query.max(in_map), smaller = in_query.min(in_map);
    const Eigen::Array<bool, Eigen::Dynamic, 1> agree =
        larger - smaller <= options.tolerance_m + kRelativeTolerance * larger &&
        smaller >= options.min_separation_m;
    for (Eigen::Index k = 0; k < i; ++k) {
      if (!agree[k]) continue;
      const Correspondence& b = correspondences[nodes[k]];
      if (a.query != b.query && a.map != b.map) graph.connect(nodes[i], nodes[k]);
    }
  }
  return graph;
}

std::vector<std::uint32_t> coreNumbers(const ConsistencyGraph& graph) {
  // Batagelj & Zaversnik 2003: peel a node of the smallest degree; buckets keep nodes by degree.
  const std::size_t n = graph.size();
  std::vector<std::uint32_t> core(n);
  std::vector<std::vector<std::uint32_t>> bucket(n + 1);
  for (std::uint32_t i = 0; i < n; ++i) bucket[core[i] = graph.degree(i)].push_back(i);
  std::vector<bool> peeled(n, false);
  for (std::size_t d = 0; d < bucket.size(); ++d) {
    while (!bucket[d].empty()) {
      const std::uint32_t node = bucket[d].back();
      bucket[d].pop_back();
      if (peeled[node] || core[node] != d) continue;  // moved to a lower bucket since
      peeled[node] = true;
      forEachBit(graph.row(node), graph.words(), [&](std::uint32_t other) {
        if (!peeled[other] && core[other] > d) bucket[--core[other]].push_back(other);
      });
    }
  }
  return core;
}

Clique maximumClique(const ConsistencyGraph& graph, int budget) {
  Clique result;
  result.proven_maximum = true;
  if (graph.size() == 0) return result;

  const auto cores = coreNumbers(graph);
  const auto order = densestFirst(cores);
  auto best = bestGreedyClique(induced(graph, order));

  // A clique larger than that lives where core numbers are at least its size: a prefix of `order`.
  auto dense = order;
  while (!dense.empty() && cores[dense.back()] < best.size()) dense.pop_back();
  if (dense.size() > best.size()) {
    const ConsistencyGraph rest = induced(graph, dense);
    CliqueSearch search(rest, best, budget);
    result.proven_maximum = search.run();
    best = search.best();
  }
  for (const std::uint32_t i : best) result.nodes.push_back(order[i]);
  std::sort(result.nodes.begin(), result.nodes.end());
  return result;
}

}  // namespace xview
