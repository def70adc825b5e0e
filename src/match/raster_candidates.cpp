// SPDX-License-Identifier: BSD-3-Clause
#include "raster_candidates.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "xview/types/pose.h"

namespace xview::raster {
namespace {

constexpr double kCells = 1.6, kYawSteps = 1.6;
constexpr int kBinBits =
    1;  // bins of 2x2 cells: what suppresses a candidate is in one of the 3x3 bins around

}  // namespace

void BestCandidates::merge(const BestCandidates& other) {
  for (const Candidate& candidate : other.candidates_) offer(candidate);
}

std::vector<Candidate> BestCandidates::sorted() && {
  prune();
  std::sort(candidates_.begin(), candidates_.end());
  return std::move(candidates_);
}

void BestCandidates::prune() {
  if (candidates_.size() <= keep_) return;
  const auto last = candidates_.begin() + static_cast<std::ptrdiff_t>(keep_ - 1);
  std::nth_element(candidates_.begin(), last, candidates_.end());
  threshold_ = last->score;
  candidates_.resize(keep_);
}

std::vector<PlacePose> distinctPoses(const std::vector<Candidate>& candidates, const YawGrid& grid,
                                     double cell_m, std::size_t keep) {
  std::vector<PlacePose> poses;
  std::vector<Candidate> kept;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> kept_in_bin;
  const auto bin = [](std::int64_t x, std::int64_t y) { return y * 0x100000001ll + x; };
  const auto suppresses = [&](const Candidate& a, const Candidate& b) {
    const double d = std::hypot(static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y));
    return d < kCells &&
           std::abs(angleDifference(grid.yaw(a.yaw), grid.yaw(b.yaw))) < kYawSteps * grid.step;
  };
  const auto isSuppressed = [&](const Candidate& c) {
    for (std::int64_t y = (c.y >> kBinBits) - 1; y <= (c.y >> kBinBits) + 1; ++y) {
      for (std::int64_t x = (c.x >> kBinBits) - 1; x <= (c.x >> kBinBits) + 1; ++x) {
        const auto it = kept_in_bin.find(bin(x, y));
        if (it == kept_in_bin.end()) continue;
        for (const std::size_t k : it->second) {
          if (suppresses(kept[k], c)) return true;
        }
      }
    }
    return false;
  };
  for (const Candidate& c : candidates) {
    if (poses.size() >= keep) break;
    if (isSuppressed(c)) continue;
    kept_in_bin[bin(c.x >> kBinBits, c.y >> kBinBits)].push_back(kept.size());
    kept.push_back(c);
    poses.push_back({(static_cast<double>(c.x) + 0.5) * cell_m,
                     (static_cast<double>(c.y) + 0.5) * cell_m, angleDifference(grid.yaw(c.yaw), 0),
                     static_cast<double>(c.score)});
  }
  return poses;
}

}  // namespace xview::raster
