// SPDX-License-Identifier: BSD-3-Clause
// A tile, before compression:
//   bitmap of known cells, bitmap of measured cells (row by row, 512 bytes each),
//   ground heights of the known cells: difference to the cell on the left, below, or before,
//   per channel: number of samples; then in columns, sorted by cell: cell index (difference), x and
//   y within the cell, height (difference to the ground of the cell if it is known, to the sample
//   before otherwise).
#include <algorithm>
#include <array>
#include <bitset>
#include <map>
#include <tuple>
#include <utility>

#include "map_tiles.h"

namespace xview::map {
namespace {

constexpr std::int64_t kSide = 64;
constexpr std::size_t kCells = kSide * kSide;
constexpr std::size_t kBitmapBytes = kCells / 8;

struct StoredSample {
  std::uint32_t cell = 0;     ///< within the tile, row by row
  std::int64_t x = 0, y = 0;  ///< centimetres from the corner of the cell
  std::int64_t z = 0;         ///< centimetres from the origin of the plan view
  bool operator<(const StoredSample& o) const {
    return std::tie(cell, y, x, z) < std::tie(o.cell, o.y, o.x, o.z);
  }
};

struct Ground {
  std::bitset<kCells> known, measured;
  std::array<std::int64_t, kCells> z{};  ///< centimetres; 0 where not known
};

struct OpenTile {
  Ground ground;
  std::array<std::vector<StoredSample>, kChannels> samples;
};

using TileKey = std::pair<std::int64_t, std::int64_t>;  // (y, x)
using OpenTiles = std::map<TileKey, OpenTile>;

/// Corner of a cell in centimetres; the same on writing and reading for any cell size.
std::int64_t cornerOf(std::int64_t cell, double cell_m) {
  return std::llround(static_cast<double>(cell) * cell_m * kStoredSteps);
}

std::int64_t cellOf(std::int64_t steps, double cell_m) {
  return static_cast<std::int64_t>(
      std::floor(static_cast<double>(steps) / (cell_m * kStoredSteps)));
}

OpenTile& openTile(OpenTiles& tiles, std::int64_t cell_x, std::int64_t cell_y) {
  return tiles[{floorDivide(cell_y, kSide), floorDivide(cell_x, kSide)}];
}

std::uint32_t cellInTile(std::int64_t cell_x, std::int64_t cell_y) {
  return static_cast<std::uint32_t>((cell_y & (kSide - 1)) * kSide + (cell_x & (kSide - 1)));
}

OpenTiles distribute(const PlanView& plan) {
  OpenTiles tiles;
  for (const GroundCell& cell : plan.known) {
    Ground& ground = openTile(tiles, cell.x, cell.y).ground;
    const std::uint32_t index = cellInTile(cell.x, cell.y);
    ground.known[index] = true;
    ground.measured[index] = cell.measured;
    ground.z[index] = toSteps(cell.z, "ground of the plan view");
  }
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    for (const PlanSample& sample : plan.samples[channel]) {
      const std::int64_t x = toSteps(sample.x, "sample of the plan view");
      const std::int64_t y = toSteps(sample.y, "sample of the plan view");
      const std::int64_t cell_x = cellOf(x, plan.cell_m), cell_y = cellOf(y, plan.cell_m);
      openTile(tiles, cell_x, cell_y)
          .samples[channel]
          .push_back({cellInTile(cell_x, cell_y), x - cornerOf(cell_x, plan.cell_m),
                      y - cornerOf(cell_y, plan.cell_m),
                      toSteps(sample.z, "sample of the plan view")});
    }
  }
  return tiles;
}

/// Ground heights change little from cell to cell: the expected one.
std::int64_t expectedGround(const Ground& ground, std::size_t cell, std::int64_t previous) {
  if (cell % kSide > 0 && ground.known[cell - 1]) return ground.z[cell - 1];
  if (cell >= kSide && ground.known[cell - kSide]) return ground.z[cell - kSide];
  return previous;
}

std::int64_t expectedHeight(const Ground& ground, std::uint32_t cell, std::int64_t previous) {
  return ground.known[cell] ? ground.z[cell] : previous;
}

void writeBitmap(const std::bitset<kCells>& bits, ByteWriter& out) {
  std::array<std::uint8_t, kBitmapBytes> bytes{};
  for (std::size_t i = 0; i < kCells; ++i) {
    if (bits[i]) bytes[i / 8] = static_cast<std::uint8_t>(bytes[i / 8] | (1u << (i % 8)));
  }
  out.raw(bytes.data(), bytes.size());
}

std::bitset<kCells> readBitmap(ByteReader& in) {
  const std::uint8_t* const bytes = in.raw(kBitmapBytes);
  std::bitset<kCells> bits;
  for (std::size_t i = 0; i < kCells; ++i) bits[i] = (bytes[i / 8] >> (i % 8)) & 1;
  return bits;
}

void writeGround(const Ground& ground, ByteWriter& out) {
  writeBitmap(ground.known, out);
  writeBitmap(ground.measured, out);
  std::int64_t previous = 0;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (!ground.known[cell]) continue;
    out.signedInteger(ground.z[cell] - expectedGround(ground, cell, previous));
    previous = ground.z[cell];
  }
}

/// A stored coordinate; the sum may wrap in a damaged file, so it is formed without sign.
std::int64_t checkedSum(std::int64_t a, std::int64_t b) {
  const auto sum =
      static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
  if (std::abs(static_cast<double>(sum)) > 2 * kFarthest_m * kStoredSteps)
    throw Damage("plan tile with a coordinate out of range");
  return sum;
}

Ground readGround(ByteReader& in) {
  Ground ground;
  ground.known = readBitmap(in);
  ground.measured = readBitmap(in);
  std::int64_t previous = 0;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (!ground.known[cell]) continue;
    previous = ground.z[cell] =
        checkedSum(expectedGround(ground, cell, previous), in.signedInteger());
  }
  return ground;
}

void writeChannel(const std::vector<StoredSample>& samples, const Ground& ground, ByteWriter& out) {
  out.unsignedInteger(samples.size());
  std::uint32_t previous_cell = 0;
  for (const StoredSample& s : samples) {
    out.unsignedInteger(s.cell - previous_cell);
    previous_cell = s.cell;
  }
  for (const StoredSample& s : samples) out.signedInteger(s.x);
  for (const StoredSample& s : samples) out.signedInteger(s.y);
  std::int64_t previous = 0;
  for (const StoredSample& s : samples) {
    out.signedInteger(s.z - expectedHeight(ground, s.cell, previous));
    previous = s.z;
  }
}

std::vector<StoredSample> readChannel(ByteReader& in, const Ground& ground) {
  std::vector<StoredSample> samples(in.itemCount());
  std::uint64_t cell = 0;
  for (StoredSample& s : samples) {
    cell += std::min<std::uint64_t>(in.unsignedInteger(), kCells);
    if (cell >= kCells) throw Damage("plan tile with a sample outside of it");
    s.cell = static_cast<std::uint32_t>(cell);
  }
  for (StoredSample& s : samples) s.x = checkedSum(in.signedInteger(), 0);
  for (StoredSample& s : samples) s.y = checkedSum(in.signedInteger(), 0);
  std::int64_t previous = 0;
  for (StoredSample& s : samples) {
    previous = s.z = checkedSum(expectedHeight(ground, s.cell, previous), in.signedInteger());
  }
  return samples;
}

PlanTile close(const TileKey& key, OpenTile& open) {
  PlanTile tile;
  tile.y = key.first;
  tile.x = key.second;
  tile.known = static_cast<std::uint32_t>(open.ground.known.count());
  ByteWriter out;
  writeGround(open.ground, out);
  for (auto& samples : open.samples) {
    std::sort(samples.begin(), samples.end());
    tile.samples += static_cast<std::uint32_t>(samples.size());
    writeChannel(samples, open.ground, out);
  }
  tile.data = compressed(out.bytes());
  return tile;
}

}  // namespace

std::vector<PlanTile> toTiles(const PlanView& plan) {
  OpenTiles open = distribute(plan);
  std::vector<PlanTile> tiles;
  tiles.reserve(open.size());
  for (auto& [key, content] : open) {
    if (!isTileIndex(key.first) || !isTileIndex(key.second)) {
      throw std::out_of_range("plan view larger than 2^20 tiles of 64 cells");
    }
    tiles.push_back(close(key, content));
  }
  return tiles;
}

void appendTile(const PlanTile& tile, PlanView& plan) {
  if (!isTileIndex(tile.x) || !isTileIndex(tile.y))
    throw Damage("plan tile with an index out of range");
  const Bytes raw = decompressed(tile.data);
  ByteReader in(raw);
  const Ground ground = readGround(in);
  if (ground.known.count() != tile.known)
    throw Damage("plan tile with another number of known cells than announced");
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (!ground.known[cell]) continue;
    plan.known.push_back(
        {static_cast<std::int32_t>(tile.x * kSide + static_cast<std::int64_t>(cell) % kSide),
         static_cast<std::int32_t>(tile.y * kSide + static_cast<std::int64_t>(cell) / kSide),
         toMetres(ground.z[cell]), ground.measured[cell]});
  }
  std::size_t count = 0;
  for (auto& samples : plan.samples) {
    for (const StoredSample& s : readChannel(in, ground)) {
      const std::int64_t corner_x = cornerOf(tile.x * kSide + s.cell % kSide, plan.cell_m);
      const std::int64_t corner_y = cornerOf(tile.y * kSide + s.cell / kSide, plan.cell_m);
      samples.push_back({toMetres(corner_x + s.x), toMetres(corner_y + s.y), toMetres(s.z)});
      ++count;
    }
  }
  if (count != tile.samples || in.remaining() > 0)
    throw Damage("plan tile with another number of samples than announced");
}

std::string channelNames() {
  std::string names;
  for (std::size_t i = 0; i < kChannels; ++i)
    names += (i > 0 ? " " : "") + std::string(toString(static_cast<Channel>(i)));
  return names;
}

}  // namespace xview::map
