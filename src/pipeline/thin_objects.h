// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/graph.h"
#include "xview/types/labels.h"
#include "xview/types/plan_view.h"

namespace xview {

/// Replaces the vertices of poles, signs and lights by those of the plan view of the same points.
/// The centre of a cluster depends on which part of a post was seen, and a cluster smears along the
/// rays of a noisy camera; a density peak does not, and its foot on the ground is the same from the
/// street and from the air. A post is a pole whatever its labels say, also that of a sign, because
/// in noise its labels differ from visit to visit; the sign is a vertex beside it. Posts without a
/// cluster of poles are of the first class of poles, if there is one. A vertex keeps what is known
/// of the nearest cluster of its kind; the new ones come last, in the order of the plan view. Edges
/// are dropped. Nothing changes without a plan view.
void placeThinObjects(SemanticGraph& graph, const PlanView& plan, const LabelSet& labels);

}  // namespace xview
