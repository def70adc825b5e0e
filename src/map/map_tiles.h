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
struct Tile {
  std::int64_t x = 0, y = 0, z = 0;  ///< floor((p - origin) / 64 m)
  std::uint32_t points = 0;
  Bytes data;
};

template <class Row>
void columns(Row& row, Tile& t) {
  row(t.x);
  row(t.y);
  row(t.z);
  row(t.points);
  row(t.data);
}

/// Tiles sorted by (z, y, x). Coordinates are rounded to 1 cm, points that are not finite are
/// dropped. Throws std::out_of_range on points too far from the origin.
std::vector<Tile> toTiles(const LabelledCloud& cloud);
/// Appends points with their instances, sorted by label, instance, position; throws Damage.
void appendTile(const Tile& tile, LabelledCloud& cloud);

/// A plan view as points: samples with their channel as label, and the cells that were seen, at
/// their middle. Throws std::out_of_range for samples that are not finite.
LabelledCloud pointsOf(const PlanView& plan);
/// Fills a plan view, which has its grid already, with the points of one; throws Damage.
void fill(const LabelledCloud& points, PlanView& plan);
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
inline std::int64_t tileId(const Tile& t) {
  return ((t.z + kTileIndexBias) << 40) | ((t.y + kTileIndexBias) << 20) | (t.x + kTileIndexBias);
}
inline bool isTileIndex(std::int64_t i) { return i >= -kTileIndexBias && i < kTileIndexBias; }

}  // namespace xview::map
