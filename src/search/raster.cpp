// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "search/raster_parts.h"
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

const LikelihoodRaster::Tiles::Place* LikelihoodRaster::Tiles::findPlace(std::int64_t tx,
                                                                         std::int64_t ty) const {
  const auto it = places.find(placeKey(tx, ty));
  return it == places.end() ? nullptr : &it->second;
}

std::uint8_t& LikelihoodRaster::Tiles::make(std::size_t channel, std::int32_t cx, std::int32_t cy,
                                            std::uint8_t value) {
  const std::int32_t tx = cx >> kTileBits, ty = cy >> kTileBits;
  highest.at(channel) = std::max(highest[channel], value);
  if (!last_written || last_written->channel != channel || last_written->tx != tx ||
      last_written->ty != ty) {
    Place& place = places[placeKey(tx, ty)];
    if (place.size() <= channel) place.resize(channel + 1, nullptr);
    Tile*& tile = place[channel];
    if (!tile) {
      Tile fresh{tx, ty, static_cast<std::uint16_t>(channel), background[channel], 0, {}};
      fresh.cells.fill(background[channel]);
      tile = &tiles.emplace_back(fresh);
    }
    last_written = tile;
  }
  Tile& tile = *last_written;
  tile.highest = std::max(tile.highest, value);
  const std::size_t cell = cellInTile(cx, cy);
  if (value != background[channel]) tile.differs |= partBit(cell);
  return tile.cells[cell];
}

LikelihoodRaster::LikelihoodRaster(double cell_m, std::vector<std::uint8_t> background_of_channel)
    : tiles_(std::make_unique<Tiles>()) {
  if (!(cell_m > 0))
    throw UsageError("likelihood raster: cell size = " + std::to_string(cell_m) + ", must be > 0");
  if (background_of_channel.size() > kMaxChannels) {
    throw UsageError("likelihood raster: " + std::to_string(background_of_channel.size()) +
                     " channels, at most " + std::to_string(kMaxChannels));
  }
  tiles_->cell_m = cell_m;
  tiles_->highest = background_of_channel;
  tiles_->background = std::move(background_of_channel);
}

LikelihoodRaster::~LikelihoodRaster() = default;
LikelihoodRaster::LikelihoodRaster(LikelihoodRaster&&) noexcept = default;
LikelihoodRaster& LikelihoodRaster::operator=(LikelihoodRaster&&) noexcept = default;

double LikelihoodRaster::cellSize() const { return tiles_->cell_m; }
std::size_t LikelihoodRaster::channels() const { return tiles_->background.size(); }
std::uint8_t LikelihoodRaster::background(std::size_t channel) const {
  return tiles_->background.at(channel);
}

void LikelihoodRaster::set(std::size_t channel, std::int32_t cx, std::int32_t cy,
                           std::uint8_t value) {
  tiles_->make(channel, cx, cy, value) = value;
}

void LikelihoodRaster::raise(std::size_t channel, std::int32_t cx, std::int32_t cy,
                             std::uint8_t value) {
  if (value <= tiles_->background.at(channel) &&
      !tiles_->find(channel, cx >> kTileBits, cy >> kTileBits))
    return;
  std::uint8_t& cell = tiles_->make(channel, cx, cy, value);
  cell = std::max(cell, value);
}

std::uint8_t LikelihoodRaster::at(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
  const Tiles::Tile* tile = tiles_->find(channel, cx >> kTileBits, cy >> kTileBits);
  return tile ? tile->cells[cellInTile(cx, cy)] : tiles_->background.at(channel);
}

std::size_t LikelihoodRaster::bytes() const {
  constexpr std::size_t kPlaceEntry = 64;  // node and bucket of the hash map
  std::size_t sum = tiles_->tiles.size() * sizeof(Tiles::Tile);
  for (const auto& [key, place] : tiles_->places)
    sum += kPlaceEntry + place.capacity() * sizeof(void*);
  return sum;
}

int rasterScore(const LikelihoodRaster& map, const std::vector<RasterSample>& samples,
                const PlacePose& pose) {
  check(map, samples);
  const double cell = map.cellSize(), c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto cellOf = [](double v) {
    return static_cast<std::int32_t>(std::floor(v + kRoundingSlack));
  };
  int score = 0;
  for (const RasterSample& q : samples) {
    const std::int32_t cx = cellOf(pose.x / cell + (c * q.x - s * q.y) / cell);
    const std::int32_t cy = cellOf(pose.y / cell + (s * q.x + c * q.y) / cell);
    score += map.at(q.channel, cx, cy) - map.background(q.channel);
  }
  return score;
}

}  // namespace xview::search
