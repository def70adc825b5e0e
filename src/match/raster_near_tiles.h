// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raster_samples.h"
#include "raster_tiles.h"

namespace xview::raster {

/// The tiles of a square by slot and place, for looking at single cells: cheaper than a Window
/// where few are wanted.
class NearTiles {
 public:
  NearTiles(const LikelihoodRaster::Tiles& tiles, const PreparedSamples& prepared,
            std::int64_t side)
      : tiles_(tiles),
        prepared_(prepared),
        across_((side >> kTileBits) + 2),
        cells_(prepared.channels.size() * static_cast<std::size_t>(across_ * across_)),
        empty_(prepared.channels.size()) {
    for (std::size_t slot = 0; slot < empty_.size(); ++slot)
      empty_[slot].fill(prepared.background[slot]);
  }

  /// Collects the tiles of the square whose first cell is (first_x, first_y).
  void load(std::int64_t first_x, std::int64_t first_y) {
    first_tx_ = first_x >> kTileBits;
    first_ty_ = first_y >> kTileBits;
    const auto places = static_cast<std::size_t>(across_ * across_);
    for (std::size_t i = 0; i < places; ++i) {
      const auto ty = static_cast<std::int64_t>(i) / across_,
                 tx = static_cast<std::int64_t>(i) % across_;
      const LikelihoodRaster::Tiles::Place* place =
          tiles_.findPlace(first_tx_ + tx, first_ty_ + ty);
      for (std::size_t slot = 0; slot < empty_.size(); ++slot) {
        const LikelihoodRaster::Tiles::Tile* tile =
            LikelihoodRaster::Tiles::tileOf(place, prepared_.channels[slot]);
        cells_[slot * places + i] = tile ? tile->cells.data() : empty_[slot].data();
      }
    }
  }

  /// Adds the cells [x, x + side) x [y, y + side) to the sums, row by row.
  void addSquare(std::size_t slot, std::int64_t x, std::int64_t y, int side,
                 std::int32_t* sums) const {
    constexpr std::int64_t kMask = kTileSide - 1;
    if ((x & kMask) + side <= kTileSide && (y & kMask) + side <= kTileSide) {
      const std::uint8_t* cell = cellAt(slot, x, y);
      for (int row = 0; row < side; ++row, cell += kTileSide) {
        for (int column = 0; column < side; ++column) *sums++ += cell[column];
      }
      return;
    }
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) *sums++ += *cellAt(slot, x + column, y + row);
    }
  }

 private:
  const std::uint8_t* cellAt(std::size_t slot, std::int64_t x, std::int64_t y) const {
    constexpr std::int64_t kMask = kTileSide - 1;
    const std::int64_t place =
        ((y >> kTileBits) - first_ty_) * across_ + (x >> kTileBits) - first_tx_;
    return cells_[slot * static_cast<std::size_t>(across_ * across_) +
                  static_cast<std::size_t>(place)] +
           (y & kMask) * kTileSide + (x & kMask);
  }

  const LikelihoodRaster::Tiles& tiles_;
  const PreparedSamples& prepared_;
  std::int64_t across_;
  std::int64_t first_tx_ = 0, first_ty_ = 0;
  std::vector<const std::uint8_t*> cells_;  ///< first cell of each tile
  std::vector<std::array<std::uint8_t, kTileSide * kTileSide>> empty_;
};

}  // namespace xview::raster
