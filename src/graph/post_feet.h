// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "graph/plan_cells.h"
#include "xview/types/plan_view.h"

namespace xview {

/// The foot of a pole that hangs in the air around a cell, of a lamp on an arm: from above it hides
/// its post and has most of the votes, but the post is there at more heights. On a short arm both
/// are in one peak, and its middle between them. Nothing if the peak stands on the ground itself
/// without such a lamp, is a sign or a light, or if no post is within 2.5 m. A post may be too thin
/// for the labels, so that it has those of the ground behind it (Strays).
std::optional<PlanSample> findFoot(const PlanCells& cells, CellIndex::Cell peak);

}  // namespace xview
