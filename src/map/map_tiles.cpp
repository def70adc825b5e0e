// SPDX-License-Identifier: BSD-3-Clause
// Points and edges are rows of whole numbers, sorted. Before compression they stand column by
// column, each number of the first columns as difference to the one before. Points: label,
// instance, voxel x, y, z in the tile, and x, y, z in the voxel in centimetres; these last three
// follow no order and are not differences. Edges: both vertices, counted from the first of the
// block. Vertices: whole numbers as differences, each column behind the other, then the bytes of
// their real numbers, all first bytes of a column, all second ones and so on.
#include "map_tiles.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <tuple>
#include <type_traits>
#include <unordered_map>

#include "base/stored_cloud.h"

namespace xview::map {
namespace {

constexpr std::size_t kSizeBytes = 4;
constexpr std::size_t kBestRatio = 1032;  // of deflate: 258 bytes from two bits

constexpr std::size_t kLongestNumber = 10;                        // bytes of a packed one
constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{4} << 20;  // rows: 128 MB of points

/// `differences`: the first columns, whose numbers are stored as such. A row has its numbers as
/// row[column].
template <class Row>
Bytes packed(const std::vector<Row>& rows, std::size_t columns, std::size_t differences) {
  ByteWriter out;
  for (std::size_t column = 0; column < columns; ++column) {
    std::int64_t previous = 0;
    for (const Row& row : rows) {
      const std::int64_t value = row[column];
      out.signedInteger(value - previous);
      if (column < differences) previous = value;
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
                                                   const std::array<std::int64_t, N>& largest,
                                                   std::size_t differences = N) {
  const std::size_t numbers = N * std::size_t{count};
  const Bytes raw = decompressed(data, numbers, kLongestNumber * numbers);
  ByteReader in(raw);
  std::vector<std::array<std::uint32_t, N>> rows(count);
  for (std::size_t column = 0; column < N; ++column) {
    std::uint64_t value = 0;  // wraps in a damaged file
    for (auto& row : rows) {
      if (column >= differences) value = 0;
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
/// Side of a voxel: of those of map.cloud_voxel_m each class has one point.
constexpr std::int64_t kVoxel = 25;
constexpr std::int64_t kLastVoxel = (kSide - 1) / kVoxel;
constexpr std::array<std::int64_t, 8> kLargest = {kMostId,    kMostId,    kLastVoxel, kLastVoxel,
                                                  kLastVoxel, kVoxel - 1, kVoxel - 1, kVoxel - 1};
constexpr std::size_t kSorted = 5;     ///< columns of points that are differences
constexpr std::int64_t kBlock = 4096;  // vertices whose edges are one row

constexpr std::size_t kWholeNumbers = 6, kRealNumbers = 7;  // of a vertex

/// visit(member) for each.
template <class Visit>
void forWholeNumbers(const Visit& visit) {
  visit(&Vertex::label);
  visit(&Vertex::instance);
  visit(&Vertex::observations);
  visit(&Vertex::points);
  visit(&Vertex::first_frame);
  visit(&Vertex::last_frame);
}

/// visit(number) for each: number(vertex) refers to it.
template <class Visit>
void forRealNumbers(const Visit& visit) {
  for (const Eigen::Index axis : {0, 1, 2})
    visit([axis](auto& v) -> auto& { return v.position[axis]; });
  for (const Eigen::Index axis : {0, 1, 2})
    visit([axis](auto& v) -> auto& { return v.extent[axis]; });
  visit([](auto& v) -> auto& { return v.sigma_m; });
}

std::uint64_t bitsOf(double number) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &number, sizeof bits);
  return bits;
}

/// Labels of cells of a bird's-eye view that were seen: of measured ground, and of others.
constexpr std::uint32_t kMeasured = kBevChannels, kSeen = kBevChannels + 1;

/// The numbers of a point at steps from the corner of its tile, in the order of their columns; two
/// words, since they are sorted.
class PointRow {
 public:
  PointRow(std::uint32_t label, std::uint32_t instance, std::int64_t x, std::int64_t y,
           std::int64_t z)
      : what_(std::uint64_t{label} << 32 | instance),
        where_(at(x / kVoxel, 2) | at(y / kVoxel, 3) | at(z / kVoxel, 4) | at(x % kVoxel, 5) |
               at(y % kVoxel, 6) | at(z % kVoxel, 7)) {}

  std::int64_t operator[](std::size_t column) const {
    if (column == 0) return static_cast<std::int64_t>(what_ >> 32);
    if (column == 1) return static_cast<std::int64_t>(what_ & kMostId);
    return static_cast<std::int64_t>(where_ >> shiftOf(column) & kByte);
  }
  bool operator<(const PointRow& other) const {
    return what_ != other.what_ ? what_ < other.what_ : where_ < other.where_;
  }

 private:
  static constexpr std::uint64_t kByte = 0xFF;
  static_assert(kLastVoxel <= 0xFF && kVoxel <= 0xFF);

  static unsigned shiftOf(std::size_t column) {
    return static_cast<unsigned>(8 * (kLargest.size() - 1 - column));
  }
  static std::uint64_t at(std::int64_t value, std::size_t column) {
    return static_cast<std::uint64_t>(value) << shiftOf(column);
  }

  std::uint64_t what_, where_;
};

Bytes packedPoints(std::vector<PointRow>& rows) {
  std::sort(rows.begin(), rows.end());
  return packed(rows, kLargest.size(), kSorted);
}

/// Where a point is: its tile, and steps from the corner of that. By axis.
struct TileSteps {
  std::array<std::int64_t, 3> tile, in_tile;
};

TileSteps stepsOf(const Point& p) {
  TileSteps steps{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t at = toSteps(p.getVector3fMap()[static_cast<Eigen::Index>(axis)], "point");
    steps.tile[axis] = floorDivide(at, kSide);
    steps.in_tile[axis] = at - steps.tile[axis] * kSide;
  }
  return steps;
}

/// Calls visit(label, instance, steps in the tile) for the points of a tile; throws Damage.
template <class Visit>
void forPoints(const Tile& tile, const Visit& visit) {
  using Steps = std::array<std::int64_t, 3>;
  requirePlace(tile);
  for (const auto& row : unpacked(tile.data, tile.points, kLargest, kSorted)) {
    const auto& [label, instance, voxel_x, voxel_y, voxel_z, x, y, z] = row;
    visit(label, instance, Steps{voxel_x * kVoxel + x, voxel_y * kVoxel + y, voxel_z * kVoxel + z});
  }
}

Point pointIn(const Tile& tile, const std::array<std::int64_t, 3>& in_tile, std::uint32_t label) {
  return Point(toMetres(tile.x * kSide + in_tile[0]), toMetres(tile.y * kSide + in_tile[1]),
               toMetres(tile.z * kSide + in_tile[2]), label);
}

bool isBefore(const Tile& a, const Tile& b) {
  return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

/// The points at(0) to at(count - 1). One tile is unpacked at a time: as numbers all points would
/// take several times their memory.
template <class PointAt>
std::vector<Tile> tilesOf(std::size_t count, const PointAt& at) {
  std::vector<Tile> tiles;
  std::unordered_map<std::int64_t, std::int32_t> number_of;  // by tileId
  std::vector<std::int32_t> tile_of(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    const Point p = at(i);
    if (!p.getVector3fMap().allFinite()) continue;
    const auto tile = stepsOf(p).tile;
    if (!isTileIndex(tile[0]) || !isTileIndex(tile[1]) || !isTileIndex(tile[2]))
      throw std::out_of_range("points beyond 2^20 tiles of 64 m do not fit into a map");
    Tile empty;
    std::tie(empty.x, empty.y, empty.z) = std::tie(tile[0], tile[1], tile[2]);
    const auto [found, is_new] =
        number_of.try_emplace(tileId(empty), static_cast<std::int32_t>(tiles.size()));
    if (is_new) tiles.push_back(std::move(empty));
    tile_of[i] = found->second;
    ++tiles[found->second].points;
  }
  const Grouped points(tile_of, tiles.size());
  std::vector<PointRow> rows;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    rows.clear();
    for (std::size_t k = points.starts[t]; k < points.starts[t + 1]; ++k) {
      const Point p = at(points.order[k]);
      const auto in_tile = stepsOf(p).in_tile;
      rows.emplace_back(p.label, p.instance, in_tile[0], in_tile[1], in_tile[2]);
    }
    tiles[t].data = packedPoints(rows);
  }
  std::sort(tiles.begin(), tiles.end(), isBefore);
  return tiles;
}

/// Behind rows that are all lower.
template <class Item>
void appendSorted(std::vector<Item>& items, std::vector<Item>& all) {
  std::sort(items.begin(), items.end(), InRowOrder());
  all.insert(all.end(), items.begin(), items.end());
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

std::uint8_t ByteReader::byte() {
  if (next_ == end_) throw Damage("packed numbers end too early");
  return *next_++;
}

std::int64_t ByteReader::signedInteger() {
  const std::uint64_t coded = unsignedInteger();
  return static_cast<std::int64_t>((coded >> 1) ^ (~(coded & 1) + 1));
}

Bytes compressed(const Bytes& raw, int level) {
  if (raw.size() > 0xFFFFFFFFu) throw std::length_error("a tile of more than 4 GB");
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> packer(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!packer) throw std::bad_alloc();
  Bytes packed(kSizeBytes + libdeflate_zlib_compress_bound(packer.get(), raw.size()));
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    packed[i] = static_cast<std::uint8_t>(raw.size() >> (8 * i));
  packed.resize(kSizeBytes + libdeflate_zlib_compress(packer.get(), raw.data(), raw.size(),
                                                      packed.data() + kSizeBytes,
                                                      packed.size() - kSizeBytes));
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
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!unpacker) throw std::bad_alloc();
  Bytes raw(raw_size);
  const libdeflate_result result = libdeflate_zlib_decompress(
      unpacker.get(), packed.data() + kSizeBytes, packed.size() - kSizeBytes, raw.data(),
      raw.size(), nullptr);  // no more bytes and no fewer
  if (result != LIBDEFLATE_SUCCESS) throw Damage("packed block does not decompress");
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
  return tilesOf(cloud.size(), [&](std::size_t i) { return cloud.points[i]; });
}

std::vector<Tile> toTiles(const BevGrid& bev) {
  std::array<std::size_t, kBevChannels + 1> begin{};
  for (std::size_t c = 0; c < kBevChannels; ++c) begin[c + 1] = begin[c] + bev.samples[c].size();
  const auto pointAt = [&](std::size_t i) {
    if (i >= begin.back()) {
      const GroundCell& cell = bev.known[i - begin.back()];
      return Point(static_cast<float>((cell.x + 0.5) * bev.cell_m),
                   static_cast<float>((cell.y + 0.5) * bev.cell_m), cell.z,
                   cell.measured ? kMeasured : kSeen);
    }
    const auto c = static_cast<std::size_t>(std::upper_bound(begin.begin(), begin.end(), i) -
                                            begin.begin() - 1);
    const BevSample& s = bev.samples[c][i - begin[c]];
    if (!std::isfinite(s.x + s.y + s.z))
      throw std::out_of_range("sample of the plan view that is not finite");
    return Point(s.x, s.y, s.z, static_cast<std::uint32_t>(c));
  };
  return tilesOf(begin.back() + bev.known.size(), pointAt);
}

void requirePlace(const Tile& tile) {
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y) || !isTileIndex(tile.z))
    throw Damage("tile with an index out of range");
}

void appendTile(const Tile& tile, LabelledCloud& cloud) {
  forPoints(tile, [&](std::uint32_t label, std::uint32_t instance, const auto& in_tile) {
    Point point = pointIn(tile, in_tile, label);
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

void appendTile(const Tile& tile, BevGrid& bev) {
  forPoints(tile, [&](std::uint32_t label, std::uint32_t, const auto& in_tile) {
    if (label > kSeen) throw Damage("plan view with an unknown channel");
    const Point p = pointIn(tile, in_tile, label);
    if (label < kBevChannels)
      bev.samples[label].push_back({p.x, p.y, p.z});
    else
      bev.known.push_back({static_cast<std::int32_t>(std::floor(p.x / bev.cell_m)),
                           static_cast<std::int32_t>(std::floor(p.y / bev.cell_m)), p.z,
                           label == kMeasured});
  });
}

void fill(std::vector<Tile> tiles, BevGrid& bev) {
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const Tile& a, const Tile& b) { return a.y < b.y; });
  for (auto row = tiles.begin(); row != tiles.end();) {
    const auto end =
        std::find_if(row, tiles.end(), [&](const Tile& tile) { return tile.y != row->y; });
    BevGrid of_row;
    of_row.cell_m = bev.cell_m;
    for (; row != end; ++row) appendTile(*row, of_row);
    for (std::size_t c = 0; c < kBevChannels; ++c) appendSorted(of_row.samples[c], bev.samples[c]);
    appendSorted(of_row.known, bev.known);
  }
}

std::vector<OverviewTile> toTiles(const search::MapOverview& overview) {
  std::vector<OverviewTile> tiles;
  for (const auto& [at, squares] : overview.tiles) {
    if (!isTileIndex(at.x) || !isTileIndex(at.y)) return {};
    tiles.push_back({at.x, at.y, compressed(squares)});
  }
  return tiles;
}

void appendTile(const OverviewTile& tile, search::MapOverview& overview) {
  constexpr std::size_t kSquares =
      kBevChannels * search::MapOverview::kSide * search::MapOverview::kSide;
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y))
    throw Damage("overview tile with an index out of range");
  std::vector<std::uint8_t> squares = decompressed(tile.data, kSquares, kSquares);
  for (const std::uint8_t square : squares) {
    if ((square & 15) > search::kUnknownBin || square >> 4 > search::kUnknownBin)
      throw Damage("overview tile with an unknown class");
  }
  overview.tiles.push_back(
      {{static_cast<std::int32_t>(tile.x), static_cast<std::int32_t>(tile.y)}, std::move(squares)});
}

std::string channelNames() {
  std::string names;
  for (std::size_t i = 0; i < kBevChannels; ++i)
    names += (i > 0 ? " " : "") + std::string(toString(static_cast<BevChannel>(i)));
  return names;
}

std::uint64_t checksumOf(const std::vector<Vertex>& vertices, std::size_t first,
                         std::size_t count) {
  std::uint64_t checksum = count;
  const auto mix = [&](std::uint64_t word) {
    checksum = (checksum ^ word) * 0x9E3779B97F4A7C15ull;
    checksum ^= checksum >> 32;
  };
  for (std::size_t i = first; i < first + count; ++i) {
    const Vertex& v = vertices[i];
    forWholeNumbers([&](auto member) { mix(static_cast<std::uint64_t>(v.*member)); });
    forRealNumbers([&](const auto& number) { mix(bitsOf(number(v))); });
  }
  return checksum;
}

std::vector<VertexBlock> toBlocks(const std::vector<Vertex>& vertices, const FindBlock& known) {
  std::vector<VertexBlock> blocks;
  for (std::size_t first = 0; first < vertices.size(); first += kVertexBlock) {
    const std::size_t count = std::min(kVertexBlock, vertices.size() - first);
    if (const VertexBlock* same = known ? known(first, count) : nullptr) {
      blocks.push_back(*same);
      continue;
    }
    ByteWriter out;
    forWholeNumbers([&](auto member) {
      std::int64_t previous = 0;
      for (std::size_t i = first; i < first + count; ++i) {
        const auto value = static_cast<std::int64_t>(vertices[i].*member);
        out.signedInteger(value - previous);
        previous = value;
      }
    });
    forRealNumbers([&](const auto& number) {
      for (std::size_t byte = 0; byte < sizeof(double); ++byte) {
        for (std::size_t i = first; i < first + count; ++i)
          out.byte(static_cast<std::uint8_t>(bitsOf(number(vertices[i])) >> (8 * byte)));
      }
    });
    blocks.push_back({static_cast<std::int64_t>(first), static_cast<std::uint32_t>(count),
                      compressed(out.bytes())});
    // As in packed(): what would be refused when it is read is only wrapped.
    if (count > blocks.back().data.size()) blocks.back().data = compressed(out.bytes(), 0);
  }
  return blocks;
}

namespace {

Bytes rawOf(const VertexBlock& block) {
  const std::size_t count = block.vertices, reals = kRealNumbers * sizeof(double);
  if (count == 0 || count > kVertexBlock) throw Damage("block of vertices out of place");
  return decompressed(block.data, count * (kWholeNumbers + reals),
                      count * (kWholeNumbers * kLongestNumber + reals));
}

/// Bytes of one significance of all numbers stand together.
double realNumber(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t bits = 0;
  for (std::size_t byte = 0; byte < sizeof(double); ++byte)
    bits |= std::uint64_t{bytes[byte * count]} << (8 * byte);
  double number = 0;
  std::memcpy(&number, &bits, sizeof number);
  return number;
}

}  // namespace

void requireFinite(const Vertex& vertex) {
  if (!vertex.position.allFinite()) throw Damage("vertex with a position that is not finite");
}

void appendVertices(const VertexBlock& block, std::vector<Vertex>& vertices) {
  if (block.first_vertex != static_cast<std::int64_t>(vertices.size()))
    throw Damage("block of vertices out of place");
  unpack(block, vertices);
}

void unpack(const VertexBlock& block, std::vector<Vertex>& vertices) {
  const std::size_t count = block.vertices, first = vertices.size();
  const Bytes raw = rawOf(block);
  ByteReader in(raw);
  vertices.resize(first + count);
  forWholeNumbers([&](auto member) {
    using Number = std::decay_t<decltype(Vertex().*member)>;
    std::uint64_t value = 0;  // wraps in a damaged file
    for (std::size_t i = first; i < first + count; ++i) {
      value += static_cast<std::uint64_t>(in.signedInteger());
      vertices[i].*member = static_cast<Number>(value);
      if (static_cast<std::uint64_t>(static_cast<std::int64_t>(vertices[i].*member)) != value)
        throw Damage("a vertex with a value out of range");
    }
  });
  if (in.remaining() != count * kRealNumbers * sizeof(double))
    throw Damage("a block with more bytes than vertices, or fewer");
  const std::uint8_t* bytes = raw.data() + raw.size() - in.remaining();
  forRealNumbers([&](const auto& number) {
    for (std::size_t i = 0; i < count; ++i)
      number(vertices[first + i]) = realNumber(bytes + i, count);
    bytes += count * sizeof(double);
  });
  for (std::size_t i = first; i < first + count; ++i) requireFinite(vertices[i]);
}

Eigen::AlignedBox3d boxOf(const VertexBlock& block) {
  const Bytes raw = rawOf(block);
  const std::size_t count = block.vertices, column = count * sizeof(double);
  const std::uint8_t* x = raw.data() + raw.size() - kRealNumbers * column;
  Eigen::AlignedBox3d box;
  for (const std::uint8_t* at = x; at < x + count; ++at) {
    box.extend(Eigen::Vector3d(realNumber(at, count), realNumber(at + column, count),
                               realNumber(at + 2 * column, count)));
  }
  return box;
}

std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph) {
  using Edge = std::array<std::int64_t, 2>;
  std::map<std::int64_t, std::vector<Edge>> open;
  for (const auto& [a, b] : graph.edges()) {
    const std::int64_t first = a / kBlock * kBlock;
    open[first].push_back({a - first, b - first});
  }
  std::vector<EdgeBlock> blocks;
  for (const auto& [first, rows] : open)
    blocks.push_back({first, static_cast<std::uint32_t>(rows.size()), packed(rows, 2, 2)});
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
