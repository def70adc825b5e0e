// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "xview/map/semantic_map.h"

namespace xview::test {

/// A small map with something in every part: labels, graph with an isolated vertex, BEV grid on
/// both sides of zero, cloud far from the map origin, key frames of two sources.
map::SemanticMap sampleMap(std::uint64_t seed = 1);

/// A street along x, seen 80 m wide: ground everywhere, facades, poles, as dense as a mapper makes
/// it.
BevGrid streetBev(double length_m, std::uint64_t seed);

/// Everything equal, bit by bit (but for the sign of zero).
bool isSame(const map::SemanticMap& a, const map::SemanticMap& b);
bool isSame(const LabelSet& a, const LabelSet& b);
bool isSame(const SemanticGraph& a, const SemanticGraph& b);
bool isSame(const BevGrid& a, const BevGrid& b);
bool isSame(const LabelledCloud& a, const LabelledCloud& b);

}  // namespace xview::test
