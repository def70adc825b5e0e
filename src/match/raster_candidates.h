// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "raster_samples.h"

namespace xview::raster {

/// A cell of the pose space and its score. The order is total, so that the best K are the same
/// whoever finds them.
struct Candidate {
  std::int32_t score;
  std::int32_t yaw;
  std::int64_t x, y;

  bool operator<(const Candidate& b) const {
    return std::tie(b.score, y, x, yaw) < std::tie(score, b.y, b.x, b.yaw);
  }
};

/// The best K of all candidates that are offered. A threshold below which nothing can be among them
/// rises on the way.
class BestCandidates {
 public:
  explicit BestCandidates(std::size_t keep) : keep_(keep > 0 ? keep : 1) {}

  std::int32_t threshold() const { return threshold_; }

  void offer(const Candidate& candidate) {
    if (candidate.score < threshold_) return;
    candidates_.push_back(candidate);
    if (candidates_.size() >= 2 * keep_) prune();
  }

  void merge(const BestCandidates& other);
  std::vector<Candidate> sorted() &&;

 private:
  void prune();

  std::size_t keep_;
  std::int32_t threshold_ = 1;
  std::vector<Candidate> candidates_;
};

/// Greedy non-maximum suppression within 1.6 cells and 1.6 yaw steps; candidates are sorted.
std::vector<PlacePose> distinctPoses(const std::vector<Candidate>& candidates, const YawGrid& grid,
                                     double cell_m, std::size_t keep);

}  // namespace xview::raster
