// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/base/graph.h"

namespace xview {

struct ConsistencyOptions {
  double tolerance_m = 1.5;
  double min_separation_m = 1;  ///< nearer pairs tell nothing
};

/// Pair distances may also differ by this share of the longer one: drift of the odometry.
constexpr double kRelativeTolerance = 0.02;
/// The bits of all pairs of so many correspondences take 1 MB; of more only the most similar ones
/// take part.
constexpr std::size_t kMostCorrespondences = 3000;
/// Search nodes of a maximum clique: some 0.1 s.
constexpr int kCliqueBudget = 200000;

/// Undirected graph over correspondences as one bit row per node.
class ConsistencyGraph {
 public:
  explicit ConsistencyGraph(std::size_t nodes);
  std::size_t size() const { return nodes_; }
  void connect(std::uint32_t a, std::uint32_t b);
  bool connected(std::uint32_t a, std::uint32_t b) const;
  std::uint32_t degree(std::uint32_t node) const;
  const std::uint64_t* row(std::uint32_t node) const {
    return bits_.data() + static_cast<std::size_t>(node) * words_;
  }
  std::size_t words() const { return words_; }

 private:
  std::size_t nodes_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_;
};

/// Two correspondences agree if they use different vertices on both sides and
///   | |q_a - q_b| - |m_a - m_b| | <= tolerance + kRelativeTolerance * max of the two distances,
/// both of them at least min_separation. One node per correspondence; beyond `most` the less
/// similar ones (ties: later ones) stay without edges. Positions that are not finite agree with
/// nothing. Pair distances cannot see a mirror image: the pose step must.
ConsistencyGraph pairwiseConsistency(const std::vector<Eigen::Vector3d>& query,
                                     const std::vector<Eigen::Vector3d>& map,
                                     const std::vector<Correspondence>& correspondences,
                                     const ConsistencyOptions& options,
                                     std::size_t most = kMostCorrespondences);

/// Core number of each node (largest k such that the node survives in a subgraph of minimum degree
/// k).
std::vector<std::uint32_t> coreNumbers(const ConsistencyGraph& graph);

struct Clique {
  std::vector<std::uint32_t> nodes;  ///< sorted
  bool proven_maximum = false;       ///< false if the budget ran out
};

/// Maximum clique by branch and bound with greedy colouring (Tomita & Seki 2003; bit rows after
/// San Segundo 2011) after a greedy start and k-core pruning. The budget counts search nodes, not
/// time, so the result is repeatable; whatever it is, the result is a clique.
Clique maximumClique(const ConsistencyGraph& graph, int budget = kCliqueBudget);

}  // namespace xview
