// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "xview/types/graph.h"

namespace xview {

/// Seen from above, a facade that is sampled in several storeys is one line, and a wall that was
/// taken for a hedge now and then is a wall. Of vertices of surfaces that say the same only the one
/// with the most points (then observations) stays: none has a better one of its class within 2.5 m
/// in the plane, nor one of another surface with several times its points within 2.5 m in space.
/// Returns indices, rising, of those vertices among `candidates` and of all that are no surfaces.
std::vector<std::uint32_t> distinctFromAbove(const SemanticGraph& graph,
                                             const std::vector<std::uint32_t>& candidates,
                                             const std::function<bool(std::uint32_t)>& is_surface);

/// Of a surface only the better seen half stays, those with at least as many points as is usual for
/// their class; the others are fragments and wrong labels as often as not. All that is no surface
/// stays, and all if points were not counted.
std::vector<std::uint32_t> wellSeen(const SemanticGraph& graph,
                                    std::vector<std::uint32_t> candidates,
                                    const std::function<bool(std::uint32_t)>& is_surface);

}  // namespace xview
