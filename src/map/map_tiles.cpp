// SPDX-License-Identifier: BSD-3-Clause
// Points and edges are rows of whole numbers, sorted. Before compression they stand column by
// column, each number as difference to the one before. Points: label, instance, and x, y, z in
// centimetres from the corner of the tile; edges: both vertices, counted from the first of the
// block.
#include "map_tiles.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <tuple>

#include "xview/types/stored_cloud.h"

namespace xview::map {
namespace {

constexpr std::size_t kSizeBytes = 4;
constexpr std::size_t kBestRatio = 1032;  // of deflate: 258 bytes from two bits

constexpr std::size_t kLongestNumber = 10;                        // bytes of a packed one
constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{4} << 20;  // rows: 128 MB of points

template <std::size_t N>
using NumberRows = std::vector<std::array<std::int64_t, N>>;

template <std::size_t N>
Bytes packed(const NumberRows<N>& rows) {
  ByteWriter out;
  for (std::size_t column = 0; column < N; ++column) {
    std::int64_t previous = 0;
    for (const auto& row : rows) {
      out.signedInteger(row[column] - previous);
      previous = row[column];
    }
  }
  Bytes bytes = compressed(out.bytes());
  // A regular grid of points, say: as it would be refused when it is read, it is only wrapped.
  if (rows.size() > PackedRows::kMostPerByte * bytes.size()) bytes = compressed(out.bytes(), 0);
  return bytes;
}

/// Throws Damage unless there are `count` rows of numbers from zero to the largest of each column.
template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> unpacked(const Bytes& data, std::uint32_t count,
                                                   const std::array<std::int64_t, N>& largest) {
  const std::size_t numbers = N * std::size_t{count};
  const Bytes raw = decompressed(data, numbers, kLongestNumber * numbers);
  ByteReader in(raw);
  std::vector<std::array<std::uint32_t, N>> rows(count);
  for (std::size_t column = 0; column < N; ++column) {
    std::uint64_t value = 0;  // wraps in a damaged file
    for (auto& row : rows) {
      value += static_cast<std::uint64_t>(in.signedInteger());
      if (value > static_cast<std::uint64_t>(largest[column]))
        throw Damage("a block with a value out of range");
      row[column] = static_cast<std::uint32_t>(value);
    }
  }
  if (in.remaining() > 0) throw Damage("a block with more bytes than rows");
  return rows;
}

// Of a tile, centimetres.
constexpr auto kSide = static_cast<std::int64_t>(StoredCloud::kColumn_m * kStoredSteps);
constexpr std::int64_t kMostId = std::numeric_limits<std::uint32_t>::max();
constexpr std::array<std::int64_t, 5> kLargest = {kMostId, kMostId, kSide - 1, kSide - 1,
                                                  kSide - 1};
constexpr std::int64_t kBlock = 4096;  // vertices whose edges are one row

/// Labels of cells of a bird's-eye view that were seen: of measured ground, and of others.
constexpr std::uint32_t kMeasured = kBevChannels, kSeen = kBevChannels + 1;

/// Calls visit(label, instance, x, y, z) for the points of a tile; throws Damage.
template <class Visit>
void forPoints(const Tile& tile, const Visit& visit) {
  requirePlace(tile);
  for (const auto& [label, instance, x, y, z] : unpacked(tile.data, tile.points, kLargest))
    visit(label, instance, toMetres(tile.x * kSide + x), toMetres(tile.y * kSide + y),
          toMetres(tile.z * kSide + z));
}

bool isBefore(const Tile& a, const Tile& b) {
  return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

}  // namespace

void ByteWriter::unsignedInteger(std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::uint8_t>(value | 0x80));
  bytes_.push_back(static_cast<std::uint8_t>(value));
}

void ByteWriter::signedInteger(std::int64_t value) {
  unsignedInteger((static_cast<std::uint64_t>(value) << 1) ^ (value < 0 ? ~std::uint64_t{0} : 0));
}

std::uint64_t ByteReader::unsignedInteger() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (next_ == end_) throw Damage("packed numbers end too early");
    const std::uint8_t byte = *next_++;
    value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
    if (byte < 0x80) return value;
  }
  throw Damage("packed number longer than 64 bits");
}

std::int64_t ByteReader::signedInteger() {
  const std::uint64_t coded = unsignedInteger();
  return static_cast<std::int64_t>((coded >> 1) ^ (~(coded & 1) + 1));
}

Bytes compressed(const Bytes& raw, int level) {
  if (raw.size() > 0xFFFFFFFFu) throw std::length_error("a tile of more than 4 GB");
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  Bytes packed(kSizeBytes + size);
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    packed[i] = static_cast<std::uint8_t>(raw.size() >> (8 * i));
  const int result = compress2(packed.data() + kSizeBytes, &size, raw.data(),
                               static_cast<uLong>(raw.size()), level);
  if (result != Z_OK) throw std::bad_alloc();
  packed.resize(kSizeBytes + size);
  return packed;
}

Bytes decompressed(const Bytes& packed, std::size_t least, std::size_t most) {
  if (packed.size() < kSizeBytes) throw Damage("packed block too short");
  std::size_t raw_size = 0;
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    raw_size |= static_cast<std::size_t>(packed[i]) << (8 * i);
  if (raw_size > packed.size() * kBestRatio)
    throw Damage("packed block announces an impossible size");
  if (raw_size < least || raw_size > most)
    throw Damage("packed block of " + std::to_string(raw_size) + " bytes, expected " +
                 std::to_string(least) + " to " + std::to_string(most) + " for its rows");
  Bytes raw(raw_size + 1);  // one spare byte tells a stream that is longer than announced
  uLongf size = static_cast<uLongf>(raw.size());
  const int result = uncompress(raw.data(), &size, packed.data() + kSizeBytes,
                                static_cast<uLong>(packed.size() - kSizeBytes));
  if (result != Z_OK || size != raw_size) throw Damage("packed block does not decompress");
  raw.resize(raw_size);
  return raw;
}

PackedRows::PackedRows(std::uint64_t file_bytes)
    : file_bytes_(file_bytes), left_(std::max(kAlwaysAllowed, kMostPerByte * file_bytes)) {}

void PackedRows::take(const char* what, std::uint32_t rows, std::uint64_t announced) {
  if (rows > left_)
    throw Damage(std::string(what) + ": more than a map of " + std::to_string(file_bytes_) +
                 " bytes can hold");
  left_ -= rows;
  in_part_ += rows;
  if (in_part_ > announced)
    throw Damage(std::string(what) + ": expected " + std::to_string(announced) + ", found more");
}

std::int64_t toSteps(double metres, const char* what) {
  if (!(std::abs(metres) <= kFarthest_m)) {
    throw std::out_of_range(std::string(what) + " at " + std::to_string(metres) +
                            " m from the origin; at most 100000 km fit into a map");
  }
  return std::llround(metres * kStoredSteps);
}

std::vector<Tile> toTiles(const LabelledCloud& cloud) {
  std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, NumberRows<5>> open;  // z, y, x
  for (const Point& p : cloud.points) {
    if (!p.getVector3fMap().allFinite()) continue;
    const std::int64_t x = toSteps(p.x, "point"), y = toSteps(p.y, "point"),
                       z = toSteps(p.z, "point");
    const std::int64_t tx = floorDivide(x, kSide), ty = floorDivide(y, kSide),
                       tz = floorDivide(z, kSide);
    open[{tz, ty, tx}].push_back(
        {p.label, p.instance, x - tx * kSide, y - ty * kSide, z - tz * kSide});
  }
  std::vector<Tile> tiles;
  for (auto& [key, rows] : open) {
    const auto& [z, y, x] = key;
    if (!isTileIndex(x) || !isTileIndex(y) || !isTileIndex(z))
      throw std::out_of_range("points beyond 2^20 tiles of 64 m do not fit into a map");
    std::sort(rows.begin(), rows.end());
    tiles.push_back({x, y, z, static_cast<std::uint32_t>(rows.size()), packed(rows)});
  }
  return tiles;
}

void requirePlace(const Tile& tile) {
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y) || !isTileIndex(tile.z))
    throw Damage("tile with an index out of range");
}

void appendTile(const Tile& tile, LabelledCloud& cloud) {
  forPoints(tile, [&](std::uint32_t label, std::uint32_t instance, float x, float y, float z) {
    Point point(x, y, z, label);
    point.instance = instance;
    cloud.points.push_back(point);
  });
}

void mergeTiles(const std::vector<Tile>& addition, std::vector<Tile>& tiles) {
  std::vector<Tile> all;
  all.reserve(tiles.size() + addition.size());
  std::merge(tiles.begin(), tiles.end(), addition.begin(), addition.end(), std::back_inserter(all),
             isBefore);
  const auto twice = std::adjacent_find(
      all.begin(), all.end(), [](const Tile& a, const Tile& b) { return !isBefore(a, b); });
  if (twice != all.end()) throw std::logic_error("points of one tile are packed and unpacked");
  tiles = std::move(all);
}

LabelledCloud pointsOf(const BevGrid& bev) {
  LabelledCloud cloud;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (const BevSample& s : bev.samples[c]) {
      if (!std::isfinite(s.x + s.y + s.z))
        throw std::out_of_range("sample of the plan view that is not finite");
      cloud.points.emplace_back(s.x, s.y, s.z, static_cast<std::uint32_t>(c));
    }
  }
  for (const GroundCell& cell : bev.known) {
    cloud.points.emplace_back(static_cast<float>((cell.x + 0.5) * bev.cell_m),
                              static_cast<float>((cell.y + 0.5) * bev.cell_m), cell.z,
                              cell.measured ? kMeasured : kSeen);
  }
  return cloud;
}

void fill(const std::vector<Tile>& tiles, BevGrid& bev) {
  for (const Tile& tile : tiles) {
    forPoints(tile, [&](std::uint32_t label, std::uint32_t, float x, float y, float z) {
      if (label > kSeen) throw Damage("plan view with an unknown channel");
      if (label < kBevChannels)
        bev.samples[label].push_back({x, y, z});
      else
        bev.known.push_back({static_cast<std::int32_t>(std::floor(x / bev.cell_m)),
                             static_cast<std::int32_t>(std::floor(y / bev.cell_m)), z,
                             label == kMeasured});
    });
  }
  for (auto& samples : bev.samples)
    std::sort(samples.begin(), samples.end(), inRowOrder<BevSample>);
  std::sort(bev.known.begin(), bev.known.end(), inRowOrder<GroundCell>);
}

std::string channelNames() {
  std::string names;
  for (std::size_t i = 0; i < kBevChannels; ++i)
    names += (i > 0 ? " " : "") + std::string(toString(static_cast<BevChannel>(i)));
  return names;
}

std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph) {
  std::map<std::int64_t, NumberRows<2>> open;
  for (const auto& [a, b] : graph.edges()) {
    const std::int64_t first = a / kBlock * kBlock;
    open[first].push_back({a - first, b - first});
  }
  std::vector<EdgeBlock> blocks;
  for (const auto& [first, rows] : open)
    blocks.push_back({first, static_cast<std::uint32_t>(rows.size()), packed(rows)});
  return blocks;
}

void setEdges(const std::vector<EdgeBlock>& blocks, SemanticGraph& graph) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  const auto vertices = static_cast<std::int64_t>(graph.size());
  for (const EdgeBlock& block : blocks) {
    const std::int64_t first = block.first_vertex;
    if (first < 0 || first % kBlock != 0 || first >= vertices)
      throw Damage("block of edges out of place");
    const std::array<std::int64_t, 2> largest = {kBlock - 1, vertices - 1 - first};
    for (const auto& [a, b] : unpacked(block.data, block.edges, largest)) {
      if (a >= b) throw Damage("edge to a vertex before it");
      edges.emplace_back(static_cast<std::uint32_t>(first + a),
                         static_cast<std::uint32_t>(first + b));
    }
  }
  graph.setEdges(edges);
}

}  // namespace xview::map
