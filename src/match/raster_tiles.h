// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "xview/match/raster_search.h"

namespace xview {

constexpr int kTileBits = 6;
constexpr int kTileSide = 1 << kTileBits;
constexpr int kPartSide = 8;  ///< cells of the blocks that Tile::differs tells of
constexpr int kParts = kTileSide / kPartSide;

/// The storage of a LikelihoodRaster.
struct LikelihoodRaster::Tiles {
  struct Tile {
    std::int32_t tx, ty;  ///< cell (cx, cy) is in tile (cx >> 6, cy >> 6)
    std::uint16_t channel;
    std::uint8_t highest;  ///< no cell of the tile is above this
    std::uint64_t
        differs;  ///< bit 8 * (y / 8) + x / 8: that 8x8 block may differ from the background
    std::array<std::uint8_t, kTileSide * kTileSide> cells;  ///< row-major
  };

  double cell_m;
  std::vector<std::uint8_t> background;
  std::vector<std::uint8_t> highest;  ///< per channel: no cell is above this
  std::deque<Tile> tiles;             ///< in order of creation; addresses are stable
  /// The tiles of one place by channel; null where nothing was written.
  using Place = std::vector<Tile*>;
  std::unordered_map<std::uint64_t, Place> places;
  Tile* last_written = nullptr;

  /// Null if no channel has a tile there.
  const Place* findPlace(std::int64_t tx, std::int64_t ty) const;
  static const Tile* tileOf(const Place* place, std::size_t channel) {
    return place && channel < place->size() ? (*place)[channel] : nullptr;
  }
  const Tile* find(std::size_t channel, std::int64_t tx, std::int64_t ty) const {
    return tileOf(findPlace(tx, ty), channel);
  }
  /// The cell, created if absent, that is about to receive `value`.
  std::uint8_t& make(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);
};

}  // namespace xview
