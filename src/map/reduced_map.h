// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "base/channel_moves.h"
#include "xview/map/semantic_map.h"

namespace xview::map {

/// What changes in a map for queries that tell fewer classes apart.
struct Reduction {
  ChannelMoves moves;  ///< of its view
  /// The class that points and vertices of a class become; null if they keep theirs.
  std::function<std::uint32_t(std::uint32_t)> label;
  LabelSet labels;  ///< of these classes
};

/// A map with less detail. What is packed stays packed and is reduced where somebody asks for it;
/// the rest is copied.
SemanticMap reduced(const SemanticMap& map, const Reduction& reduction);

}  // namespace xview::map
