// SPDX-License-Identifier: BSD-3-Clause
#include "base/cells.h"

#include "xview/base/budget.h"

namespace xview {

void HeightLattice::fillGaps(std::int32_t reach) {
  constexpr std::size_t kAsked = 4096;  // cells between two looks at the budget
  std::vector<std::int32_t> queue;
  std::vector<float> known;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (std::isnan(heights[i])) continue;
    queue.push_back(static_cast<std::int32_t>(i));
    known.push_back(heights[i]);
  }
  const float typical = known.empty() ? 0.f : medianOf(std::move(known));
  for (std::size_t k = 0; k < queue.size(); ++k) {
    if (k % kAsked == 0) askBudget("the heights of the ground");
    index.forAround(queue[k], reach, [&](std::int32_t cell) {
      if (!std::isnan(heights[cell])) return;
      heights[cell] = heights[queue[k]];
      queue.push_back(cell);
    });
  }
  std::replace_if(
      heights.begin(), heights.end(), [](float z) { return std::isnan(z); }, typical);
}

}  // namespace xview
