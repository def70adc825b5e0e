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

inline AllVertices allVertices(const SemanticMap& map) {
  return map.stored_vertices ? AllVertices(*map.stored_vertices) : AllVertices(map.graph);
}
/// Moves them to where those of a map are. Throws Error.
void unpackVertices(SemanticMap& map);

/// Rounds its view and its points as saveMap does, so that it finds the same before and after. What
/// was measured of them stays.
void roundAsStored(SemanticMap& map);

/// Packs all points of a map of canonical scale, which rounds them as well.
void packPoints(SemanticMap& map);

/// Moves all packed points to where those of a map are, behind its others.
void unpackPoints(SemanticMap& map);
/// The same for the columns of 64 m in which `near` has points.
void unpackPointsAround(const LabelledCloud& near, SemanticMap& map);

/// Whether something of it is packed.
inline bool isPacked(const SemanticMap& map) {
  return map.stored_points || map.stored_view || map.stored_vertices;
}

/// Of which recording a key frame is; all are of the first one if the map does not say.
inline std::uint32_t sourceOf(const SemanticMap& map, std::size_t key_frame) {
  return key_frame < map.source_of_pose.size() ? map.source_of_pose[key_frame] : 0;
}

/// What a map has, without unpacking it.
struct Counts {
  std::size_t vertices = 0, points = 0, samples = 0;
};
Counts countsOf(const SemanticMap& map);

/// That of its file, or of its view, vertices, points and key frames if it is of none. Throws
/// Error.
std::uint64_t checksumOf(const SemanticMap& map);

/// Calls visit(points) for the points of `cloud` and then column by column for packed ones, all
/// from the origin of the cloud. isWanted(PlaneCell) chooses columns. Throws Error.
template <class Visit, class IsWanted>
void forPoints(const SemanticMap& map, const IsWanted& isWanted, const Visit& visit) {
  visit(map.cloud);
  if (!map.stored_points) return;
  for (const PlaneCell& column : map.stored_points->columns()) {
    if (isWanted(column)) visit(*map.stored_points->pointsOf(column));
  }
}

}  // namespace xview::map
