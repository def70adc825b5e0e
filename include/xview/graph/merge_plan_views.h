// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/plan_view.h"

namespace xview {

/// Adds what another view of the same frame saw. Where `view` measured the ground, its heights and
/// ground classes stay; upright classes are joined, one sample per cell, since each pass may have
/// seen another side. Objects within 1 m of one of their channel in `view` are the same. Merging a
/// view again changes nothing. `view.aerial` stays. Views of other cell sizes cannot be merged
/// (UsageError).
void mergePlanViews(PlanView& view, const PlanView& addition);

}  // namespace xview
