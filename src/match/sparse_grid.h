// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>

namespace xview {

/// Values on an unbounded plane of cells; 32x32 cells at a time come into being when one is
/// written.
template <class Value>
class SparseGrid {
 public:
  /// Null if nothing was written near the cell.
  const Value* find(std::int64_t cx, std::int64_t cy) const {
    const auto it = tiles_.find(key(cx >> kBits, cy >> kBits));
    return it == tiles_.end() ? nullptr : &(*it->second)[cellInTile(cx, cy)];
  }

  Value& at(std::int64_t cx, std::int64_t cy) {
    const std::uint64_t wanted = key(cx >> kBits, cy >> kBits);
    if (!last_ || wanted != last_key_) {
      std::unique_ptr<Tile>& tile = tiles_[wanted];
      if (!tile) tile = std::make_unique<Tile>();
      last_ = tile.get();
      last_key_ = wanted;
    }
    return (*last_)[cellInTile(cx, cy)];
  }

  std::size_t bytes() const { return tiles_.size() * (sizeof(Tile) + 64); }

 private:
  static constexpr int kBits = 5;
  static constexpr std::int64_t kSide = 1 << kBits;
  using Tile = std::array<Value, kSide * kSide>;

  static std::uint64_t key(std::int64_t tx, std::int64_t ty) {
    return (static_cast<std::uint64_t>(tx) << 32) | (static_cast<std::uint64_t>(ty) & 0xFFFFFFFFu);
  }
  static std::size_t cellInTile(std::int64_t cx, std::int64_t cy) {
    return static_cast<std::size_t>((cy & (kSide - 1)) * kSide + (cx & (kSide - 1)));
  }

  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  Tile* last_ = nullptr;
  std::uint64_t last_key_ = 0;
};

}  // namespace xview
