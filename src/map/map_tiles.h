// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/cells.h"
#include "search/distance_field.h"
#include "xview/base/bev_grid.h"
#include "xview/base/graph.h"
#include "xview/base/labelled_cloud.h"

namespace xview::map {

/// The bytes of a map file contradict themselves. Becomes an Error with the path at the border of
/// the folder.
class Damage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Bytes = std::vector<std::uint8_t>;

/// Appends integers in as few bytes as they need: seven bits per byte, least significant first.
/// Signed ones are zig-zag coded, so that small negative numbers are short too.
class ByteWriter {
 public:
  void unsignedInteger(std::uint64_t value);
  void signedInteger(std::int64_t value);
  void byte(std::uint8_t value) { bytes_.push_back(value); }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

/// Reads what ByteWriter wrote; throws Damage when the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(const Bytes& bytes)
      : next_(bytes.data()), end_(bytes.data() + bytes.size()) {}
  std::uint64_t unsignedInteger();
  std::int64_t signedInteger();
  std::uint8_t byte();
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

/// zlib stream behind its raw size (4 bytes, little endian). The stream carries its own checksum.
/// `level`: 0 = only wrapped, to 9.
Bytes compressed(const Bytes& raw, int level = 6);
/// Throws Damage if the stream is broken, or claims a size that it cannot have, or one that is not
/// in [least, most].
Bytes decompressed(const Bytes& packed, std::size_t least = 0,
                   std::size_t most = std::numeric_limits<std::uint32_t>::max());

/// Points and edges are packed so well that a file of a megabyte could hold a billion of them. How
/// many it may hold is bounded by its size, and known before anything is unpacked.
class PackedRows {
 public:
  explicit PackedRows(std::uint64_t file_bytes);
  /// Throws Damage if the rows of `what` are more than are left, or with those taken before more
  /// than `announced`.
  void take(const char* what, std::uint32_t rows, std::uint64_t announced);
  /// The next rows are of something else, so that the announced ones are counted anew.
  void beginPart() { in_part_ = 0; }
  /// No more than this is packed into a byte when it is written.
  static constexpr std::uint64_t kMostPerByte = 8;

 private:
  std::uint64_t file_bytes_, left_, in_part_ = 0;
};

/// Resolution of stored single-precision coordinates: one centimetre.
constexpr double kStoredSteps = 100;  // per metre

/// Nothing farther from its origin than this fits into a map [m].
constexpr double kFarthest_m = 1e8;

/// Coordinate in whole centimetres. Throws std::out_of_range; `what` names the owner.
std::int64_t toSteps(double metres, const char* what);

inline float toMetres(std::int64_t steps) {
  return static_cast<float>(static_cast<double>(steps) / kStoredSteps);
}

inline std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

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
/// Throws Damage if a tile has indices that none can have.
void requirePlace(const Tile& tile);
/// Appends points with their instances, sorted by label, instance, position; throws Damage.
void appendTile(const Tile& tile, LabelledCloud& cloud);

/// Adds them where the tiles of `tiles` are; both sorted. Throws std::logic_error if a tile is in
/// both.
void mergeTiles(const std::vector<Tile>& addition, std::vector<Tile>& tiles);

/// The same of a bird's-eye view: samples are points with their channel as label, cells that were
/// seen points at their middle. Throws std::out_of_range for samples that are not finite, too.
std::vector<Tile> toTiles(const BevGrid& bev);
/// Fills a bird's-eye view, which has its grid already, with the tiles of one; throws Damage.
void fill(std::vector<Tile> tiles, BevGrid& bev);
/// Appends a tile of one, in any order; throws Damage.
void appendTile(const Tile& tile, BevGrid& bev);

/// A tile of the view that was made for the first look at a large map.
struct OverviewTile {
  std::int64_t x = 0, y = 0;  ///< in tiles of 64 x 64 cells
  Bytes data;
};

template <class Row>
void columns(Row& row, OverviewTile& t) {
  row(t.x);
  row(t.y);
  row(t.data);
}

/// None of a map that is too wide for their ids.
std::vector<OverviewTile> toTiles(const search::MapOverview& overview);
/// Throws Damage.
void appendTile(const OverviewTile& tile, search::MapOverview& overview);
/// Names of the channels in the order of storage; another order is another file.
std::string channelNames();

/// Up to 1024 successive vertices.
struct VertexBlock {
  std::int64_t first_vertex = 0;
  std::uint32_t vertices = 0;
  Bytes data;
};

template <class Row>
void columns(Row& row, VertexBlock& block) {
  row(block.vertices);
  row(block.data);
}

constexpr std::size_t kVertexBlock = 1024;
/// Of all that a block of these vertices would hold.
std::uint64_t checksumOf(const std::vector<Vertex>& vertices, std::size_t first, std::size_t count);
/// The block that holds `count` vertices from the first on, or null: it need not be packed anew.
using FindBlock = std::function<const VertexBlock*(std::size_t first, std::size_t count)>;
std::vector<VertexBlock> toBlocks(const std::vector<Vertex>& vertices,
                                  const FindBlock& known = nullptr);
/// Throws Damage unless its position is finite.
void requireFinite(const Vertex& vertex);
/// Appends them; throws Damage.
void appendVertices(const VertexBlock& block, std::vector<Vertex>& vertices);
/// The same wherever the block stands among others.
void unpack(const VertexBlock& block, std::vector<Vertex>& vertices);
/// Around their positions, which stand first among the real numbers; throws Damage.
Eigen::AlignedBox3d boxOf(const VertexBlock& block);

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
inline std::int64_t tileId(const OverviewTile& t) {
  return ((t.y + kTileIndexBias) << 20) | (t.x + kTileIndexBias);
}
inline std::int64_t tileId(const Tile& t) {
  return ((t.z + kTileIndexBias) << 40) | ((t.y + kTileIndexBias) << 20) | (t.x + kTileIndexBias);
}
inline bool isTileIndex(std::int64_t i) { return i >= -kTileIndexBias && i < kTileIndexBias; }

}  // namespace xview::map
