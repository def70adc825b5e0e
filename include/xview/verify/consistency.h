// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/option_field.h"

namespace xview::verify {

struct ConsistencyOptions {
  double tolerance_m =
      1.5;  ///< two correspondences agree if their pair distances differ by less than this
  double relative = 0.02;          ///< plus this share of the distance (drift of the odometry)
  double min_separation_m = 1;     ///< pairs nearer than this say nothing
  int max_correspondences = 3000;  ///< only the most similar ones take part
  int clique_budget =
      200000;  ///< branch-and-bound nodes; the best clique so far is returned when it is used up
};

template <class Visitor>
void visit(ConsistencyOptions& o, Visitor&& field) {
  field("tolerance_m", o.tolerance_m, Range{0.001, 1e3},
        "pair distances may differ by this much [m]");
  field("relative", o.relative, Range{0, 1}, "and by this share of the distance");
  field("min_separation_m", o.min_separation_m, Range{0, 1e3}, "ignore pairs nearer than this [m]");
  field("max_correspondences", o.max_correspondences, Range{3, 20000},
        "use only the most similar ones beyond this");
  field("clique_budget", o.clique_budget, Range{1, 1e9},
        "search nodes of the maximum clique before it settles for the best so far");
}

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
///   | |q_a - q_b| - |m_a - m_b| | <= tolerance + relative * max of the two distances,
/// both of them at least min_separation. One node per correspondence; beyond max_correspondences
/// the less similar ones (ties: later ones) stay without edges. Positions that are not finite agree
/// with nothing. Pair distances cannot see a mirror image: the pose step must.
ConsistencyGraph pairwiseConsistency(const std::vector<Eigen::Vector3d>& query,
                                     const std::vector<Eigen::Vector3d>& map,
                                     const std::vector<Correspondence>& correspondences,
                                     const ConsistencyOptions& options);

}  // namespace xview::verify
