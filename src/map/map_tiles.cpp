// SPDX-License-Identifier: BSD-3-Clause
// A tile of a cloud, before compression: in columns and as difference to the point before, label,
// instance, and x, y, z in centimetres from the corner of the tile; points sorted in this order.
// A block of edges, before compression: per vertex the number of neighbours with a larger index,
// and each as difference to the one before.
#include "map_tiles.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

namespace xview::map {
namespace {

// ---- clouds

constexpr std::int64_t kSide = 6400;  // centimetres

struct StoredPoint {
  std::uint32_t label = 0, instance = 0;
  std::int32_t x = 0, y = 0, z = 0;  ///< centimetres, [0, kSide)
  bool operator<(const StoredPoint& o) const {
    return std::tie(label, instance, x, y, z) < std::tie(o.label, o.instance, o.x, o.y, o.z);
  }
};

/// visit(field, largest value) for each column of a tile, in order.
template <class Visit>
void forEachField(Visit&& visit) {
  visit(&StoredPoint::label, std::numeric_limits<std::uint32_t>::max());
  visit(&StoredPoint::instance, std::numeric_limits<std::uint32_t>::max());
  visit(&StoredPoint::x, kSide - 1);
  visit(&StoredPoint::y, kSide - 1);
  visit(&StoredPoint::z, kSide - 1);
}

using TileKey = std::tuple<std::int64_t, std::int64_t, std::int64_t>;  // (z, y, x)

std::map<TileKey, std::vector<StoredPoint>> distribute(const LabelledCloud& cloud) {
  std::map<TileKey, std::vector<StoredPoint>> tiles;
  for (const Point& p : cloud.points) {
    if (!p.getVector3fMap().allFinite()) continue;
    const std::int64_t x = toSteps(p.x, "point of the cloud"),
                       y = toSteps(p.y, "point of the cloud"),
                       z = toSteps(p.z, "point of the cloud");
    const std::int64_t tx = floorDivide(x, kSide), ty = floorDivide(y, kSide),
                       tz = floorDivide(z, kSide);
    tiles[{tz, ty, tx}].push_back({p.label, p.instance, static_cast<std::int32_t>(x - tx * kSide),
                                   static_cast<std::int32_t>(y - ty * kSide),
                                   static_cast<std::int32_t>(z - tz * kSide)});
  }
  return tiles;
}

Bytes packed(std::vector<StoredPoint>& points) {
  std::sort(points.begin(), points.end());
  ByteWriter out;
  forEachField([&](auto field, std::int64_t) {
    std::int64_t previous = 0;
    for (const StoredPoint& p : points) {
      out.signedInteger(static_cast<std::int64_t>(p.*field) - previous);
      previous = p.*field;
    }
  });
  return compressed(out.bytes());
}

std::vector<StoredPoint> unpacked(const CloudTile& tile) {
  const Bytes raw = decompressed(tile.data);
  if (tile.points > raw.size()) throw Damage("cloud tile announces more points than bytes");
  ByteReader in(raw);
  std::vector<StoredPoint> points(tile.points);
  forEachField([&](auto field, std::int64_t largest) {
    std::uint64_t value = 0;  // wraps in a damaged file
    for (StoredPoint& p : points) {
      value += static_cast<std::uint64_t>(in.signedInteger());
      if (value > static_cast<std::uint64_t>(largest))
        throw Damage("cloud tile with a value out of range");
      p.*field = static_cast<std::remove_reference_t<decltype(p.*field)>>(value);
    }
  });
  if (in.remaining() > 0) throw Damage("cloud tile with more bytes than points");
  return points;
}

// ---- edges

constexpr std::size_t kBlock = 4096;

EdgeBlock blockFrom(std::size_t first, const SemanticGraph& graph) {
  EdgeBlock block;
  block.first_vertex = static_cast<std::int64_t>(first);
  ByteWriter out;
  for (std::size_t i = first; i < std::min(first + kBlock, graph.size()); ++i) {
    const auto& list = graph.neighbours[i];
    const auto larger = std::upper_bound(list.begin(), list.end(), static_cast<std::uint32_t>(i));
    out.unsignedInteger(static_cast<std::uint64_t>(list.end() - larger));
    std::uint32_t previous = static_cast<std::uint32_t>(i);
    for (auto j = larger; j != list.end(); ++j) {
      out.unsignedInteger(*j - previous);
      previous = *j;
      ++block.edges;
    }
  }
  block.data = compressed(out.bytes());
  return block;
}

/// The neighbours with a larger index: how many each vertex has, and those of all vertices one
/// after the other.
struct LargerNeighbours {
  std::vector<std::uint32_t> counts;
  std::vector<std::uint32_t> all;
};

void readBlock(const EdgeBlock& block, LargerNeighbours& larger) {
  const Bytes raw = decompressed(block.data);
  ByteReader in(raw);
  const std::size_t vertices = larger.counts.size(), before = larger.all.size(),
                    first = static_cast<std::size_t>(block.first_vertex);
  for (std::size_t i = first; i < std::min(first + kBlock, vertices); ++i) {
    const std::size_t count = in.itemCount();
    std::uint64_t neighbour = i;
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t step = in.unsignedInteger();
      if (step == 0 || step >= vertices || neighbour + step >= vertices)
        throw Damage("edge to a vertex that does not exist");
      neighbour += step;
      larger.all.push_back(static_cast<std::uint32_t>(neighbour));
    }
    larger.counts[i] = static_cast<std::uint32_t>(count);
  }
  if (in.remaining() > 0 || larger.all.size() - before != block.edges) {
    throw Damage("block with another number of edges than announced");
  }
}

}  // namespace

std::vector<CloudTile> toTiles(const LabelledCloud& cloud) {
  auto open = distribute(cloud);
  std::vector<CloudTile> tiles;
  tiles.reserve(open.size());
  for (auto& [key, points] : open) {
    const auto& [z, y, x] = key;
    tiles.push_back({x, y, z, static_cast<std::uint32_t>(points.size()), packed(points)});
  }
  return tiles;
}

void appendTile(const CloudTile& tile, LabelledCloud& cloud) {
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y) || !isTileIndex(tile.z)) {
    throw Damage("cloud tile with an index out of range");
  }
  for (const StoredPoint& p : unpacked(tile)) {
    Point point;
    point.x = toMetres(tile.x * kSide + p.x);
    point.y = toMetres(tile.y * kSide + p.y);
    point.z = toMetres(tile.z * kSide + p.z);
    point.label = p.label;
    point.instance = p.instance;
    cloud.points.push_back(point);
  }
}

std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph) {
  std::vector<EdgeBlock> blocks;
  for (std::size_t first = 0; first < graph.size(); first += kBlock) {
    EdgeBlock block = blockFrom(first, graph);
    if (block.edges > 0) blocks.push_back(std::move(block));
  }
  return blocks;
}

void setEdges(const std::vector<EdgeBlock>& blocks, SemanticGraph& graph) {
  LargerNeighbours larger;
  larger.counts.assign(graph.size(), 0);
  std::size_t next = 0;  // first vertex that no block has reached yet
  for (const EdgeBlock& block : blocks) {
    const auto first = static_cast<std::size_t>(block.first_vertex);
    if (block.first_vertex < 0 || first % kBlock != 0 || first < next || first >= graph.size()) {
      throw Damage("block of edges out of place");
    }
    readBlock(block, larger);
    next = first + kBlock;
  }
  std::vector<std::uint32_t> degrees = larger.counts;
  for (const std::uint32_t j : larger.all) ++degrees[j];
  graph.neighbours.assign(graph.size(), {});
  for (std::size_t i = 0; i < graph.size(); ++i) graph.neighbours[i].reserve(degrees[i]);
  // In ascending order of i every list receives first its smaller, then its larger neighbours:
  // sorted without sorting.
  auto neighbour = larger.all.begin();
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (std::uint32_t left = larger.counts[i]; left > 0; --left, ++neighbour) {
      graph.neighbours[i].push_back(*neighbour);
      graph.neighbours[*neighbour].push_back(static_cast<std::uint32_t>(i));
    }
  }
}

}  // namespace xview::map
