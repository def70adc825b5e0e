// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "graph/plan_cells.h"
#include "xview/types/plan_view.h"

namespace xview {

/// Thin upright things of any label: a network may call a lamp post vegetation in all frames of a
/// drive and a pole in the next one, but it stands alone and is taller than it is wide. Each needs
/// `min_votes` below and above 2 m, and next to nothing within 1.5 m of it at either height. Where
/// nearly all labels agree they are believed: then it is a trunk, or whatever they say.
std::vector<PlanSample> findColumns(const PlanCells& cells, double min_votes);

}  // namespace xview
