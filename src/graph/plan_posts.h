// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/plan_cells.h"
#include "xview/types/plan_view.h"

namespace xview {

/// Poles, signs and lights as density peaks, because clusters of them smear along the ray with
/// noise, and what is pole-like by its shape. They are where they stand on the ground.
void findPosts(const PlanCells& cells, const PlanOptions& options, PlanView& view);

}  // namespace xview
