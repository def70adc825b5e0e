// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "inputs.h"
#include "tool.h"
#include "xview/localizer.h"

namespace xview::tools {

/// Of one cloud that was refused: the axis that is up, or the unit of its lengths, with which it is
/// found in the map, and what to type then; nothing if there is none. It is read and looked for
/// again, so that nothing is said that does not help.
std::optional<std::string> hintFor(const QueryInput& refused, const InputFlags& input,
                                   const Localizer& localizer, const Job& job);

}  // namespace xview::tools
