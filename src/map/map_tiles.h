// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "packed_bytes.h"
#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/plan_view.h"

namespace xview::map {

// The bulk of a map in pieces, each one row of a table. columns() lists what stands behind the key,
// in the order of the table, for writing and for reading.

/// The points of a cloud in a cube of 64 m.
struct CloudTile {
  std::int64_t x = 0, y = 0, z = 0;  ///< floor((p - origin) / 64 m)
  std::uint32_t points = 0;
  Bytes data;
};

template <class Row>
void columns(Row& row, CloudTile& t) {
  row(t.x);
  row(t.y);
  row(t.z);
  row(t.points);
  row(t.data);
}

/// Tiles sorted by (z, y, x). Coordinates are rounded to 1 cm, points that are not finite are
/// dropped. Throws std::out_of_range on points too far from the origin.
std::vector<CloudTile> toTiles(const LabelledCloud& cloud);
/// Appends points with their instances, sorted by label, instance, position; throws Damage.
void appendTile(const CloudTile& tile, LabelledCloud& cloud);

/// What a plan view has in a square of 64 x 64 cells.
struct PlanTile {
  std::int64_t x = 0, y = 0;  ///< floor(cell index / 64)
  std::uint32_t known = 0;    ///< cells that were seen
  std::uint32_t samples = 0;
  Bytes data;
};

template <class Row>
void columns(Row& row, PlanTile& t) {
  row(t.x);
  row(t.y);
  row(t.known);
  row(t.samples);
  row(t.data);
}

/// Tiles sorted by (y, x). Coordinates are rounded to 1 cm; a cell known twice counts once. Throws
/// std::out_of_range on coordinates that are not finite or too far.
std::vector<PlanTile> toTiles(const PlanView& plan);
/// Appends the content of a tile; throws Damage. `plan` has its grid already. Known cells come tile
/// by tile.
void appendTile(const PlanTile& tile, PlanView& plan);
/// Names of the channels in the order of storage; another order is another file.
std::string channelNames();

/// The edges from 4096 successive vertices to later ones. Maps have ten times as many edges as
/// vertices, too many for a row each.
struct EdgeBlock {
  std::int64_t first_vertex = 0;  ///< the key
  std::uint32_t edges = 0;
  Bytes data;
};

template <class Row>
void columns(Row& row, EdgeBlock& b) {
  row(b.edges);
  row(b.data);
}

/// Blocks with at least one edge, in order.
std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph);
/// Fills the neighbour lists of a graph that has its vertices; throws Damage.
void setEdges(const std::vector<EdgeBlock>& blocks, SemanticGraph& graph);

/// Row id of a tile: packs its indices so that ids do not change when tiles are added.
constexpr std::int64_t kTileIndexBias = std::int64_t{1} << 19;
inline std::int64_t tileId(std::int64_t x, std::int64_t y, std::int64_t z = 0) {
  return ((z + kTileIndexBias) << 40) | ((y + kTileIndexBias) << 20) | (x + kTileIndexBias);
}
inline bool isTileIndex(std::int64_t i) { return i >= -kTileIndexBias && i < kTileIndexBias; }

}  // namespace xview::map
