// SPDX-License-Identifier: BSD-3-Clause
#include "place/row_loops.h"

#include <cmath>

namespace xview {
namespace {

// Compiled with -O3 -ffp-contract=off: vectors of any width, but the same roundings with all of
// them.
#define XVIEW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

constexpr float kNoDepthFrom = 1e9F;
constexpr std::size_t kCountedAtOnce = 1 << 20;  ///< fits counters of 32 bits

}  // namespace

XVIEW_CLONES void projectRow(const RowOfRays& row, const float* __restrict depth, std::size_t width,
                             float* __restrict px, float* __restrict py, float* __restrict pz,
                             float* __restrict range, std::uint8_t* __restrict state) {
  const RowOfRays r = row;
  const float y2 = r.y * r.y;
  const auto across = [&](std::size_t u) {
    return r.first_x + static_cast<float>(static_cast<std::int32_t>(u)) * r.step_x;
  };
  for (std::size_t u = 0; u < width; ++u) range[u] = depth[u];
  if (r.depth_is_range) {
    for (std::size_t u = 0; u < width; ++u)
      range[u] = depth[u] / std::sqrt(across(u) * across(u) + y2 + 1);
  }
  for (std::size_t u = 0; u < width; ++u) {
    const float x = across(u), z = range[u];
    const float range2 = z * z * (x * x + y2 + 1);
    px[u] = (r.towards[0] + r.across[0] * x) * z + r.shift[0];
    py[u] = (r.towards[1] + r.across[1] * x) * z + r.shift[1];
    pz[u] = (r.towards[2] + r.across[2] * x) * z + r.shift[2];
    range[u] = std::sqrt(range2);
    const int measured = (depth[u] > 0) & (depth[u] < kNoDepthFrom);
    const int in_range = (range2 >= r.min_range2) & (range2 <= r.max_range2);
    state[u] = static_cast<std::uint8_t>((1 - measured) * kNoDepth +
                                         (measured & (1 - in_range)) * kOutOfRange);
  }
}

XVIEW_CLONES DepthCounts countDepths(const float* depth, std::size_t count, float above,
                                     float upto) {
  DepthCounts counts;
  for (std::size_t first = 0; first < count; first += kCountedAtOnce) {
    const std::size_t end = first + kCountedAtOnce < count ? first + kCountedAtOnce : count;
    std::uint32_t measured = 0, within = 0;
    for (std::size_t i = first; i < end; ++i) {
      const float z = depth[i];
      const bool is_depth = (z > 0) & (z < kNoDepthFrom);
      measured += is_depth;
      within += is_depth & (z > above) & (z <= upto);
    }
    counts.measured += measured;
    counts.within += within;
  }
  return counts;
}

}  // namespace xview
