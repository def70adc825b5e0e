// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster.h"

#include <algorithm>
#include <string>
#include <utility>

#include "xview/types/error.h"

namespace xview::search {
namespace {

constexpr std::size_t kMaxChannels = 4096;

std::uint64_t placeKey(std::int64_t tx, std::int64_t ty) {
  return (static_cast<std::uint64_t>(tx) << 32) | (static_cast<std::uint64_t>(ty) & 0xFFFFFFFFu);
}

std::size_t cellInTile(std::int32_t cx, std::int32_t cy) {
  return static_cast<std::size_t>((cy & (kTileSide - 1)) * kTileSide + (cx & (kTileSide - 1)));
}

std::uint64_t partBit(std::size_t cell) {
  const std::size_t part = cell / (kTileSide * kPartSide) * kParts + cell % kTileSide / kPartSide;
  return std::uint64_t{1} << part;
}

}  // namespace

LikelihoodRaster::LikelihoodRaster(double cell_m, std::vector<std::uint8_t> background_of_channel)
    : cell_m_(cell_m), background_(std::move(background_of_channel)) {
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

}  // namespace xview::search
