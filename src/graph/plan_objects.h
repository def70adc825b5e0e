// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/plan_cells.h"
#include "xview/types/plan_view.h"

namespace xview {

/// Point-like things: posts (findPosts), vehicles, trunks and other objects as clusters of cells,
/// trees as maxima of the canopy.
void findPlanObjects(const PlanCells& cells, const PlanOptions& options, PlanView& view);

}  // namespace xview
