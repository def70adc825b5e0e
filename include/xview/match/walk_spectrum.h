// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/match/walks.h"

namespace xview {

/// The exact limit of sampleWalks for many walks with duplicates allowed: every walk word, in
/// increasing order, with its probability times num_walks. Same strategy (immediate return or not),
/// no randomness. Work grows with the edges and words within reach, not with the walks.
std::vector<WalkCount> walkSpectrum(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                                    std::uint32_t vertex, const WalkOptions& options);

}  // namespace xview
