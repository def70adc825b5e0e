// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "inputs.h"
#include "tool.h"
#include "xview/localizer.h"

namespace xview::tools {

/// What to type of a query that was refused: the last frames of a recording by which it is found;
/// the axis that is up, or the unit of the lengths of a cloud, with which it is found: it is looked
/// for again, so that nothing is said that does not help. Else that it shows far more than the map.
/// Nothing if there is no such thing.
std::optional<std::string> hintFor(const QueryInput& refused, const InputFlags& input,
                                   const map::SemanticMap& map, const Localizer& localizer,
                                   const Job& job);

}  // namespace xview::tools
