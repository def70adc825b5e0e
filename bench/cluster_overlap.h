// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview::bench {

/// How well clusters are the objects they should be.
struct ClusterScore {
  std::size_t objects = 0, clusters = 0;
  std::size_t matched = 0;  ///< objects that a cluster covers well enough; each cluster counts once
  double mean_overlap = 0;  ///< of the matched ones; NaN if there are none
  double precision() const;  ///< matched / clusters; NaN if there are none
  double recall() const;     ///< matched / objects; NaN if there are none
};

/// Point by point, the number of its object and of its cluster. Objects and clusters match if they
/// share more than `min_overlap` of the points of either (intersection over union); from 0.5 on
/// each has at most one partner, below that the best pairs come first. Points with object
/// `no_object` are background: they are no object, and no part of the union either if
/// `ignore_background`. Points with a negative cluster are in none. Throws std::invalid_argument if
/// the sizes differ.
struct OverlapRule {
  double min_overlap = 0.5;
  std::uint32_t no_object = 0;
  bool ignore_background = false;
};

ClusterScore scoreClusters(const std::vector<std::uint32_t>& object_of_point,
                           const std::vector<int>& cluster_of_point, const OverlapRule& rule);

}  // namespace xview::bench
