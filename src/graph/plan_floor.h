// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/plan_cells.h"
#include "xview/types/plan_view.h"

namespace xview {

/// Road, sidewalk, terrain and lane markings, and the borders between the first three.
void addFloor(const PlanCells& cells, const PlanOptions& options, PlanView& view);

}  // namespace xview
