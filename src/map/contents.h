// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "base/stored_cloud.h"
#include "base/stored_vertices.h"
#include "base/stored_view.h"
#include "search/field.h"
#include "xview/map/semantic_map.h"

namespace xview::map {

// What a map holds, whether it is packed, read late or in memory.

/// The whole view of a map, unpacked if it was not. Throws Error.
const BevGrid& viewOf(const SemanticMap& map);
/// Moves it to where that of a map is.
void unpackView(SemanticMap& map);
/// Whether a map has a view, packed or not.
bool hasView(const SemanticMap& map);
/// What a view has within a box [m, upright axes of the map], and more. Throws Error. It must not
/// outlive the map.
std::shared_ptr<const BevGrid> viewWithin(const Eigen::AlignedBox2d& box, const SemanticMap& map);
/// search::fingerprintOf() the view.
std::uint64_t fingerprintOfView(const SemanticMap& map);
/// Merges a view of the same alignment into that of a map, whose overview grows with it. A packed
/// one stays packed, and is unpacked only around the addition. Throws Error.
void growView(const BevGrid& addition, SemanticMap& map);
/// Whether the overview is that of `bev` as it is now.
bool hasOverview(const SemanticMap& map);
/// For a surface field, which refers to the map.
search::MapView searchedView(const SemanticMap& map);

/// Of a map, packed or not.
std::size_t vertexCount(const SemanticMap& map);
inline AllVertices allVertices(const SemanticMap& map) {
  return map.stored_vertices ? AllVertices(*map.stored_vertices) : AllVertices(map.graph);
}
/// Throws std::out_of_range for a number that none has, and Error.
Vertex vertexOf(const SemanticMap& map, std::uint32_t number);
/// Moves them to where those of a map are. Throws Error.
void unpackVertices(SemanticMap& map);

/// Packs all points of a map of canonical scale, which rounds them as saveMap does.
void packPoints(SemanticMap& map);

/// Moves all packed points to where those of a map are, behind its others.
void unpackPoints(SemanticMap& map);
/// The same for the columns of 64 m in which `near` has points.
void unpackPointsAround(const LabelledCloud& near, SemanticMap& map);

/// Whether something of it is packed.
inline bool isPacked(const SemanticMap& map) {
  return map.stored_points || map.stored_view || map.stored_vertices;
}
/// Moves all that is packed to where that of a map is. Throws Error.
inline void unpack(SemanticMap& map) {
  unpackPoints(map);
  unpackView(map);
  unpackVertices(map);
}

/// The packed points of a map; null if there are none.
const StoredCloud* storedPoints(const SemanticMap& map);
std::size_t pointCount(const SemanticMap& map);

}  // namespace xview::map
