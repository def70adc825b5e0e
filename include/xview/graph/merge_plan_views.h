// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/plan_view.h"

namespace xview {

/// Adds what another view of the same frame saw. Where both saw a cell, the ground and the ground classes of `view` stay; upright classes are
/// joined, since each pass may have seen another side. Objects within 1 m of one of their channel are the same. Views of other
/// cell sizes cannot be merged (UsageError).
void mergePlanViews(PlanView& view, const PlanView& addition);

}  // namespace xview
