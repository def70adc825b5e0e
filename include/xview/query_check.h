// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "xview/map/semantic_map.h"
#include "xview/place_builder.h"

namespace xview {

/// Why a query cannot be found in the map wherever it is, and what to do about it; nothing if it is
/// worth a search. Both are at canonical scale; the query is in the classes of the map unless they
/// have nothing in common.
std::optional<std::string> whyUnfindable(const Query& query, const map::SemanticMap& map);

}  // namespace xview
