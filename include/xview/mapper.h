// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/place_builder.h"

namespace xview {

/// Map of one or more recordings in one common frame, in the classes of the first (LabelMatch;
/// Error if another one has none of them). `seen` is called with every frame, in order.
map::SemanticMap buildMap(
    const std::vector<const FrameSource*>& sources, const Options& options,
    const Progress& progress = {},
    const std::function<void(const FrameSource&, const FrameDigest&)>& seen = {});
/// Map of a bare graph.
map::SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels,
                          const std::string& source, const Options& options);

/// Adds a recording or another map's content to a map in the same frame, in the classes of the map.
void appendToMap(map::SemanticMap& map, const map::SemanticMap& addition, const Options& options);

}  // namespace xview
