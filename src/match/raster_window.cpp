// SPDX-License-Identifier: BSD-3-Clause
#include "raster_window.h"

#include <algorithm>
#include <cstring>

namespace xview::raster {

using Tiles = LikelihoodRaster::Tiles;

namespace {

constexpr int kPartBits = 3;
static_assert(1 << kPartBits == kPartSide, "parts are found by shifts");
constexpr double kDenseShare = 0.6;

}  // namespace

Window::Window(const LikelihoodRaster::Tiles& tiles, const PreparedSamples& prepared,
               std::int64_t side)
    : tiles_(tiles),
      prepared_(prepared),
      side_(side),
      parts_(side / kPartSide + 2),
      cells_(prepared.channels.size() * static_cast<std::size_t>(side * side)),
      highest_(prepared.channels.size()),
      dense_(prepared.channels.size()),
      part_sums_(prepared.channels.size() * static_cast<std::size_t>((parts_ + 1) * (parts_ + 1))) {
}

void Window::load(std::int64_t first_x, std::int64_t first_y) {
  first_x_ = first_x;
  first_y_ = first_y;
  highest_ = prepared_.background;
  std::fill(part_sums_.begin(), part_sums_.end(), 0);
  for (std::int64_t ty = first_y >> kTileBits; ty <= (first_y + side_ - 1) >> kTileBits; ++ty) {
    for (std::int64_t tx = first_x >> kTileBits; tx <= (first_x + side_ - 1) >> kTileBits; ++tx) {
      const Tiles::Place* place = tiles_.findPlace(tx, ty);
      for (std::size_t slot = 0; slot < prepared_.channels.size(); ++slot) {
        const Tiles::Tile* tile = Tiles::tileOf(place, prepared_.channels[slot]);
        copyTile(slot, tile, tx, ty);
        if (tile) noteTile(slot, *tile);
      }
    }
  }
  for (std::size_t slot = 0; slot < prepared_.channels.size(); ++slot) countParts(slot);
}

/// Marks the parts of the window that the tile fills, one right and below of their place.
void Window::noteTile(std::size_t slot, const Tiles::Tile& tile) {
  highest_[slot] = std::max(highest_[slot], tile.highest);
  std::uint32_t* sums =
      part_sums_.data() + slot * static_cast<std::size_t>((parts_ + 1) * (parts_ + 1));
  const std::int64_t px0 = tile.tx * std::int64_t{kParts} - (first_x_ >> kPartBits);
  const std::int64_t py0 = tile.ty * std::int64_t{kParts} - (first_y_ >> kPartBits);
  for (std::int64_t y = std::max<std::int64_t>(0, -py0);
       y < std::min<std::int64_t>(kParts, parts_ - py0); ++y) {
    for (std::int64_t x = std::max<std::int64_t>(0, -px0);
         x < std::min<std::int64_t>(kParts, parts_ - px0); ++x) {
      if (tile.differs >> (y * kParts + x) & 1)
        sums[(py0 + y + 1) * (parts_ + 1) + px0 + x + 1] = 1;
    }
  }
}

void Window::copyTile(std::size_t slot, const Tiles::Tile* tile, std::int64_t tx, std::int64_t ty) {
  const std::int64_t x0 = std::max(first_x_, tx * kTileSide),
                     x1 = std::min(first_x_ + side_, (tx + 1) * kTileSide);
  const std::int64_t y0 = std::max(first_y_, ty * kTileSide),
                     y1 = std::min(first_y_ + side_, (ty + 1) * kTileSide);
  const auto length = static_cast<std::size_t>(x1 - x0);
  std::uint8_t* layer = cells_.data() + static_cast<std::int64_t>(slot) * side_ * side_;
  for (std::int64_t y = y0; y < y1; ++y) {
    std::uint8_t* to = layer + (y - first_y_) * side_ + (x0 - first_x_);
    if (tile) {
      std::memcpy(to, tile->cells.data() + (y - ty * kTileSide) * kTileSide + (x0 - tx * kTileSide),
                  length);
    } else {
      std::memset(to, prepared_.background[slot], length);
    }
  }
}

void Window::countParts(std::size_t slot) {
  const std::int64_t stride = parts_ + 1;
  std::uint32_t* sums = part_sums_.data() + slot * static_cast<std::size_t>(stride * stride);
  for (std::int64_t y = 1; y <= parts_; ++y) {
    std::uint32_t row = 0;
    for (std::int64_t x = 1; x <= parts_; ++x) {
      row += sums[y * stride + x];
      sums[y * stride + x] = row + sums[(y - 1) * stride + x];
    }
  }
  dense_[slot] = sums[stride * stride - 1] > kDenseShare * static_cast<double>(parts_ * parts_);
}

bool Window::mayDiffer(std::size_t slot, std::int64_t x, std::int64_t y, std::int64_t width,
                       std::int64_t height) const {
  const std::int64_t stride = parts_ + 1;
  const std::uint32_t* sums = part_sums_.data() + slot * static_cast<std::size_t>(stride * stride);
  const auto part = [](std::int64_t first, std::int64_t cell) {
    return ((first + cell) >> kPartBits) - (first >> kPartBits);
  };
  const std::int64_t px0 = part(first_x_, x), px1 = part(first_x_, x + width - 1) + 1;
  const std::int64_t py0 = part(first_y_, y), py1 = part(first_y_, y + height - 1) + 1;
  return sums[py1 * stride + px1] + sums[py0 * stride + px0] !=
         sums[py1 * stride + px0] + sums[py0 * stride + px1];
}

}  // namespace xview::raster
