// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <utility>

#include "xview/base/error.h"

namespace xview::search {
namespace {

constexpr std::size_t kMaxChannels = 4096;

std::uint64_t placeKey(std::int64_t tx, std::int64_t ty) {
  return (static_cast<std::uint64_t>(tx) << 32) | (static_cast<std::uint64_t>(ty) & 0xFFFFFFFFu);
}

std::uint64_t nextId() {
  static std::atomic<std::uint64_t> next{0};
  return next++;
}

std::size_t cellInTile(std::int32_t cx, std::int32_t cy) {
  return static_cast<std::size_t>((cy & (kTileSide - 1)) * kTileSide + (cx & (kTileSide - 1)));
}

std::uint64_t partBit(std::size_t cell) {
  const std::size_t part = cell / (kTileSide * kPartSide) * kParts + cell % kTileSide / kPartSide;
  return std::uint64_t{1} << part;
}

#define XVIEW_INLINE inline __attribute__((always_inline))

// Vectors of the compiler, which splits them to what the processor has. Loops over plain arrays are
// an order of magnitude slower, because the accumulators do not stay in registers.
using Bytes = std::uint8_t __attribute__((vector_size(32)));
using Words = std::uint16_t __attribute__((vector_size(64)));

// 15 bits hold the sums of this many groups; the 16th tells the sign of a difference.
constexpr std::size_t kGroupsPerWord = 128;
static_assert(kGroupsPerWord * 255 < 32768, "sums must fit");

/// A row of 64 cells.
struct RowSum {
  Words left, right;
};

XVIEW_INLINE void addGroup(const BlockScan& scan, std::size_t group, std::ptrdiff_t row,
                           RowSum& sum) {
  Bytes left{}, right{};
  for (std::uint32_t k = scan.groups[group]; k < scan.groups[group + 1]; ++k) {
    const std::uint8_t* cells = scan.samples[k] + row;
    Bytes a, b;
    std::memcpy(&a, cells, sizeof a);
    std::memcpy(&b, cells + sizeof a, sizeof b);
    left += a;
    right += b;
  }
  sum.left += __builtin_convertvector(left, Words);
  sum.right += __builtin_convertvector(right, Words);
}

/// Of differences instead of comparisons, which the compiler does lane by lane.
XVIEW_INLINE bool anyReaches(const RowSum& sum, std::uint16_t threshold) {
  const Words limit = Words{} + static_cast<std::uint16_t>(threshold - 1);
  const Words negative_if_reached = (limit - sum.left) | (limit - sum.right);
  std::uint64_t parts[8];
  std::memcpy(parts, &negative_if_reached, sizeof parts);
  const std::uint64_t any =
      parts[0] | parts[1] | parts[2] | parts[3] | parts[4] | parts[5] | parts[6] | parts[7];
  return (any & 0x8000800080008000u) != 0;
}

template <class Sum>
XVIEW_INLINE BlockHit* report(const Sum* sums, int row, std::uint32_t threshold, BlockHit* hits) {
  for (int column = 0; column < kBlock; ++column) {
    if (sums[column] < threshold) continue;
    *hits++ = {static_cast<std::uint16_t>(row), static_cast<std::uint16_t>(column), sums[column]};
  }
  return hits;
}

XVIEW_INLINE std::size_t scanNarrow(const BlockScan& scan, BlockHit* hits) {
  if (scan.threshold > 32767) return 0;
  const auto threshold = static_cast<std::uint16_t>(scan.threshold);
  BlockHit* end = hits;
  for (int row = 0; row < scan.rows; ++row) {
    RowSum sum{};
    for (std::size_t g = 0; g < scan.group_count; ++g) addGroup(scan, g, row * scan.stride, sum);
    if (!anyReaches(sum, threshold)) continue;
    std::uint16_t sums[kBlock];
    std::memcpy(sums, &sum, sizeof sums);
    end = report(sums, row, scan.threshold, end);
  }
  return static_cast<std::size_t>(end - hits);
}

/// For numbers of samples at which 16 bits might overflow.
XVIEW_INLINE std::size_t scanWide(const BlockScan& scan, BlockHit* hits) {
  BlockHit* end = hits;
  for (int row = 0; row < scan.rows; ++row) {
    std::uint32_t sums[kBlock] = {};
    for (std::size_t first = 0; first < scan.group_count; first += kGroupsPerWord) {
      RowSum sum{};
      for (std::size_t g = first; g < scan.group_count && g < first + kGroupsPerWord; ++g) {
        addGroup(scan, g, row * scan.stride, sum);
      }
      std::uint16_t part[kBlock];
      std::memcpy(part, &sum, sizeof part);
      for (int column = 0; column < kBlock; ++column) sums[column] += part[column];
    }
    end = report(sums, row, scan.threshold, end);
  }
  return static_cast<std::size_t>(end - hits);
}

}  // namespace

LikelihoodRaster::LikelihoodRaster(double cell_m, std::vector<std::uint8_t> background_of_channel)
    : id_(nextId()), cell_m_(cell_m), background_(std::move(background_of_channel)) {
  if (!(cell_m > 0))
    throw UsageError("likelihood raster: cell size = " + std::to_string(cell_m) + ", must be > 0");
  if (channels() > kMaxChannels) {
    throw UsageError("likelihood raster: " + std::to_string(channels()) + " channels, at most " +
                     std::to_string(kMaxChannels));
  }
}

const LikelihoodRaster::Place* LikelihoodRaster::findPlace(std::int64_t tx, std::int64_t ty) const {
  const auto it = places_.find(placeKey(tx, ty));
  return it == places_.end() ? nullptr : &it->second;
}

/// The cell, created if absent, that is about to receive `value`.
std::uint8_t& LikelihoodRaster::make(std::size_t channel, std::int32_t cx, std::int32_t cy,
                                     std::uint8_t value) {
  const std::int32_t tx = cx >> kTileBits, ty = cy >> kTileBits;
  const std::uint8_t empty = background_.at(channel);
  if (!last_written_ || last_written_->channel != channel || last_written_->tx != tx ||
      last_written_->ty != ty) {
    Place& place = places_[placeKey(tx, ty)];
    if (place.size() <= channel) place.resize(channel + 1, nullptr);
    Tile*& tile = place[channel];
    if (!tile) {
      tile = &tiles_.emplace_back(Tile{tx, ty, static_cast<std::uint16_t>(channel), empty, 0, {}});
      tile->cells.fill(empty);
    }
    last_written_ = tile;
  }
  Tile& tile = *last_written_;
  tile.highest = std::max(tile.highest, value);
  const std::size_t cell = cellInTile(cx, cy);
  if (value != empty) tile.differs |= partBit(cell);
  return tile.cells[cell];
}

void LikelihoodRaster::add(const Tile& tile) {
  make(tile.channel, tile.tx * kTileSide, tile.ty * kTileSide, background(tile.channel));
  *last_written_ = tile;
}

void LikelihoodRaster::set(std::size_t channel, std::int32_t cx, std::int32_t cy,
                           std::uint8_t value) {
  make(channel, cx, cy, value) = value;
}

void LikelihoodRaster::raise(std::size_t channel, std::int32_t cx, std::int32_t cy,
                             std::uint8_t value) {
  if (value <= background(channel) && !find(channel, cx, cy)) return;
  std::uint8_t& cell = make(channel, cx, cy, value);
  cell = std::max(cell, value);
}

std::uint8_t LikelihoodRaster::at(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
  const Tile* tile = find(channel, cx, cy);
  return tile ? tile->cells[cellInTile(cx, cy)] : background(channel);
}

// Integers only, so that all variants give the same hits.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"))) std::size_t scanBlock(
    const BlockScan& scan, BlockHit* hits) {
  return scan.group_count <= kGroupsPerWord ? scanNarrow(scan, hits) : scanWide(scan, hits);
}

}  // namespace xview::search
