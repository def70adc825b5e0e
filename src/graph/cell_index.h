// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace xview {

/// std::floor is a call of a function on processors without SSE 4.1, and this is done for every
/// point.
inline std::int32_t floorToInt(double value) {
  const auto toward_zero = static_cast<std::int32_t>(value);
  return toward_zero - (value < toward_zero);
}

/// Numbers the occupied cells of an unbounded grid: (x, y) -> 0, 1, 2 … in order of first use.
/// Cells live in 64x64 tiles, so that a look-up near the last ones costs a few instructions and a
/// road network costs its streets, not its bounding box. Remembers the last tiles: not for several
/// threads at once.
class CellIndex {
 public:
  /// Number of the cell, or -1.
  std::int32_t find(std::int32_t x, std::int32_t y) const {
    const Tile* tile = findTile(x >> 6, y >> 6);
    return tile ? (*tile)[slot(x, y)] : -1;
  }

  std::int32_t findOrAdd(std::int32_t x, std::int32_t y) {
    std::int32_t& number = (*addTile(x >> 6, y >> 6))[slot(x, y)];
    if (number < 0) {
      number = static_cast<std::int32_t>(cells_.size());
      cells_.push_back({x, y});
    }
    return number;
  }

  struct Cell {
    std::int32_t x, y;
  };
  const std::vector<Cell>& cells() const { return cells_; }
  std::size_t size() const { return cells_.size(); }

 private:
  using Tile = std::array<std::int32_t, 64 * 64>;
  struct Recent {
    std::uint64_t key = 0;
    Tile* tile = nullptr;
  };

  static std::size_t slot(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & 63) * 64 + static_cast<std::size_t>(x & 63);
  }
  static std::uint64_t key(std::int32_t tx, std::int32_t ty) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(tx)) << 32) |
           static_cast<std::uint32_t>(ty);
  }
  /// The tiles that were asked for last, one for each of 4x4 neighbouring ones.
  Recent& recentOf(std::int32_t tx, std::int32_t ty) const {
    return recent_[(tx & 3) + 4 * (ty & 3)];
  }
  Tile* findTile(std::int32_t tx, std::int32_t ty) const {
    const std::uint64_t k = key(tx, ty);
    Recent& recent = recentOf(tx, ty);
    if (recent.tile && k == recent.key) return recent.tile;
    const auto it = tiles_.find(k);
    if (it == tiles_.end()) return nullptr;
    recent = {k, it->second.get()};
    return recent.tile;
  }
  Tile* addTile(std::int32_t tx, std::int32_t ty) {
    if (Tile* found = findTile(tx, ty)) return found;
    auto& tile = tiles_[key(tx, ty)];
    tile = std::make_unique<Tile>();
    tile->fill(-1);
    return tile.get();
  }

  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  std::vector<Cell> cells_;
  mutable std::array<Recent, 16> recent_;
};

}  // namespace xview
