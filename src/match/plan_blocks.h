// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/plan_view.h"

namespace xview {

// The query holds one sample per block of surface, so that its evidence does not depend on how
// densely it was seen. A sample that stands for a larger block counts more: evidence per square
// metre (areas) or metre (lines) is constant.

/// Classes that fill areas in plan view; facades of whole blocks of houses are seen as areas, too.
inline bool fillsArea(Channel c) { return isArea(c) || c == Channel::building; }

inline double fineBlock(Channel c) { return isObject(c) ? 0.0 : fillsArea(c) ? 4.0 : 3.0; }
inline double coarseBlock(Channel c) { return isObject(c) ? 0.0 : fillsArea(c) ? 8.0 : 6.0; }

/// Weight of a sample that stands for a block of this side, relative to 2 m.
inline double blockWeight(Channel c, double block_m) {
  if (isObject(c)) return 1;
  const double side = block_m / 2;
  return fillsArea(c) ? side * side : side;
}

}  // namespace xview
