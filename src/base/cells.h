// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "base/median.h"

namespace xview {

// Points by the cells of unbounded grids.

/// What is farther than this from zero has no cell of its own: some steps on is still a number.
constexpr double kFarthestCell = 1 << 30;

/// Within kFarthestCell, whatever the value is. std::floor is a call of a function on processors
/// without SSE 4.1, and this is done for every point.
inline std::int32_t floorToInt(double value) {
  // In this order the lower bound stands for what is no number.
  const double inside = std::min(std::max(-kFarthestCell, value), kFarthestCell);
  const auto toward_zero = static_cast<std::int32_t>(inside);
  return toward_zero - (inside < toward_zero);
}

/// Cell of a lattice in the plane.
struct PlaneCell {
  std::int32_t x = 0, y = 0;

  bool operator==(const PlaneCell& o) const { return x == o.x && y == o.y; }
  std::uint64_t hash() const {
    std::uint64_t h = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
    return h ^ (h >> 29);
  }
};

/// Cell of a lattice in space, for one class, or one object of it.
struct ClassCell {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint32_t label = 0, instance = 0;

  bool operator==(const ClassCell& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label && instance == o.instance;
  }
  std::uint64_t hash() const {
    const auto pair = [](auto high, auto low) {
      return std::uint64_t{static_cast<std::uint32_t>(high)} << 32 |
             static_cast<std::uint32_t>(low);
    };
    std::uint64_t h = pair(x, y) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 32)) + pair(z, label) * 0xBF58476D1CE4E5B9ull + instance * 0x94D049BB133111EBull;
    h = (h ^ (h >> 29)) * 0x2545F4914F6CDD1Dull;
    return h ^ (h >> 32);
  }
  /// One of the 27 cells around, itself included.
  ClassCell neighbour(int i) const {
    return {x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1, label, instance};
  }
};

inline ClassCell cellOf(const Eigen::Vector3d& p, double side, std::uint32_t label) {
  return {floorToInt(p.x() / side), floorToInt(p.y() / side), floorToInt(p.z() / side), label};
}

/// Things in cells, to look for those near a point: no farther away than the side of a cell.
class CellLists {
 public:
  void add(const ClassCell& cell, std::size_t thing) { lists_[cell].push_back(thing); }
  void move(const ClassCell& from, const ClassCell& to, std::size_t thing) {
    if (from == to) return;
    std::vector<std::size_t>& list = lists_[from];
    list.erase(std::find(list.begin(), list.end(), thing));
    if (list.empty()) lists_.erase(from);
    add(to, thing);
  }
  /// Calls visit(number) for the entries in the cell and the 26 around it.
  template <class Visit>
  void forAround(const ClassCell& cell, Visit&& visit) const {
    for (int i = 0; i < 27; ++i) {
      const auto found = lists_.find(cell.neighbour(i));
      if (found == lists_.end()) continue;
      for (const std::size_t thing : found->second) visit(thing);
    }
  }
  /// Whether test(number) holds for one of them; asks the cell itself first, no more than it must.
  template <class Test>
  bool anyAround(const ClassCell& cell, Test&& test) const {
    constexpr int kItself = 13;
    for (int i = 0; i < 27; ++i) {
      const auto found = lists_.find(cell.neighbour((kItself + i) % 27));
      if (found != lists_.end() && std::any_of(found->second.begin(), found->second.end(), test))
        return true;
    }
    return false;
  }

 private:
  struct Hash {
    std::size_t operator()(const ClassCell& cell) const { return cell.hash(); }
  };
  std::unordered_map<ClassCell, std::vector<std::size_t>, Hash> lists_;
};

/// A vector that grows by chunks and never moves what it holds: the peak of a large table is its
/// size, not three times that.
template <class T>
class ChunkedVector {
 public:
  void push_back(const T& value) {
    if (size_ >> kBits == chunks_.size()) {
      chunks_.emplace_back();
      chunks_.back().reserve(kChunk);
    }
    chunks_.back().push_back(value);
    ++size_;
  }
  T& operator[](std::size_t i) { return chunks_[i >> kBits][i & (kChunk - 1)]; }
  const T& operator[](std::size_t i) const { return chunks_[i >> kBits][i & (kChunk - 1)]; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

 private:
  static constexpr std::size_t kBits = 12, kChunk = std::size_t{1} << kBits;
  std::vector<std::vector<T>> chunks_;
  std::size_t size_ = 0;
};

/// Entries by key, numbered in order of first use: a hash table with linear probing. An entry has a
/// `key`, and a key has a hash() and can be compared. It is for many points in few cells, and can
/// be told ahead what it will be asked for, because large ones outgrow the caches. The largest keep
/// their entries in a ChunkedVector.
template <class Entry, class Entries = std::vector<Entry>>
class CellTable {
 public:
  using Key = decltype(Entry::key);

  void reserve(std::size_t entries) {
    std::size_t size = slots_.empty() ? 64 : slots_.size();
    while (size < 2 * entries) size *= 2;
    if (size == slots_.size()) return;
    slots_.assign(size, Slot());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (i + kAhead < entries_.size()) prefetchSlot(entries_[i + kAhead].key);
      const std::uint64_t hash = entries_[i].key.hash();
      slots_[slotOf(entries_[i].key, hash)] = {tagOf(hash), static_cast<std::int32_t>(i)};
    }
  }

  /// Number of the entry of this key; make() makes it if it is new. Points that follow one another
  /// mostly share their cell.
  template <class Make>
  std::size_t numberOf(const Key& key, Make&& make) {
    if (last_ < entries_.size() && entries_[last_].key == key) return last_;
    if (2 * entries_.size() >= slots_.size()) reserve(entries_.size() + 1);
    const std::uint64_t hash = key.hash();
    Slot& slot = slots_[slotOf(key, hash)];
    if (slot.entry < 0) {
      slot = {tagOf(hash), static_cast<std::int32_t>(entries_.size())};
      entries_.push_back(make());
    }
    return last_ = static_cast<std::size_t>(slot.entry);
  }

  /// Number of the entry of this key, or -1.
  std::int32_t find(const Key& key) const {
    return slots_.empty() ? -1 : slots_[slotOf(key, key.hash())].entry;
  }

  Entry& operator[](std::size_t number) { return entries_[number]; }
  const Entry& operator[](std::size_t number) const { return entries_[number]; }
  std::size_t size() const { return entries_.size(); }
  Entries& entries() { return entries_; }
  const Entries& entries() const { return entries_; }

  /// What this key needs is fetched into the caches, first its slot, then its entry.
  void prefetchSlot(const Key& key) const {
    __builtin_prefetch(&slots_[key.hash() & (slots_.size() - 1)], 1);
  }
  void prefetchEntry(const Key& key) const {
    const std::int32_t entry = slots_[key.hash() & (slots_.size() - 1)].entry;
    if (entry >= 0) __builtin_prefetch(&entries_[static_cast<std::size_t>(entry)], 1);
  }

 private:
  static constexpr std::size_t kAhead = 16;
  struct Slot {
    std::uint32_t tag = 0;    ///< upper half of the hash: other entries are seldom looked at
    std::int32_t entry = -1;  ///< its number
  };
  static std::uint32_t tagOf(std::uint64_t hash) { return static_cast<std::uint32_t>(hash >> 32); }

  /// Where a key is, or where it would be put.
  std::size_t slotOf(const Key& key, std::uint64_t hash) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = hash & mask;
    while (slots_[i].entry >= 0 &&
           !(slots_[i].tag == tagOf(hash) &&
             entries_[static_cast<std::size_t>(slots_[i].entry)].key == key))
      i = (i + 1) & mask;
    return i;
  }

  Entries entries_;
  std::vector<Slot> slots_;  ///< a power of two of them, or none
  std::size_t last_ = 0;     ///< entry that was asked for last
};

/// Values of the cells of an unbounded plane, in square tiles that are made when one of their cells
/// is written.
template <class Value, int kBits = 3>
class TilePlane {
 public:
  static constexpr int kSide = 1 << kBits;
  struct Tile {
    PlaneCell key;
    std::array<Value, kSide * kSide> values{};  ///< row by row
  };

  /// Value() if nothing was written.
  Value operator()(const PlaneCell& cell) const {
    const std::int32_t number = tiles_.find(tileOf(cell));
    return number < 0 ? Value() : tiles_[static_cast<std::size_t>(number)].values[indexOf(cell)];
  }
  Value& at(const PlaneCell& cell) {
    return at(cell, [](Tile&) {});
  }
  /// The same, and fill(tile) is called for a tile that is new.
  template <class Fill>
  Value& at(const PlaneCell& cell, const Fill& fill) {
    const auto made = [&] {
      Tile tile{tileOf(cell), {}};
      fill(tile);
      return tile;
    };
    return tiles_[tiles_.numberOf(tileOf(cell), made)].values[indexOf(cell)];
  }

 private:
  static PlaneCell tileOf(const PlaneCell& cell) { return {cell.x >> kBits, cell.y >> kBits}; }
  static std::size_t indexOf(const PlaneCell& cell) {
    return static_cast<std::size_t>((cell.y & (kSide - 1)) << kBits | (cell.x & (kSide - 1)));
  }
  CellTable<Tile> tiles_;
};

/// Numbers the occupied cells of an unbounded grid: (x, y) -> 0, 1, 2 … in order of first use. A
/// road network costs its streets, not its bounding box.
class CellIndex {
 public:
  /// Number of the cell, or -1.
  std::int32_t find(std::int32_t x, std::int32_t y) const { return numbers_({x, y}) - 1; }

  std::int32_t findOrAdd(std::int32_t x, std::int32_t y) {
    std::int32_t& number = numbers_.at({x, y});
    if (number == 0) {
      cells_.push_back({x, y});
      number = static_cast<std::int32_t>(cells_.size());
    }
    return number - 1;
  }

  bool contains(const PlaneCell& cell) const { return numbers_(cell) > 0; }

  const std::vector<PlaneCell>& cells() const { return cells_; }
  std::size_t size() const { return cells_.size(); }

  /// Calls visit(number) for the occupied cells up to `reach` rows and columns away, row by row.
  template <class Visit>
  void forAround(std::size_t cell, std::int32_t reach, Visit&& visit) const {
    const PlaneCell c = cells_[cell];
    for (std::int32_t y = c.y - reach; y <= c.y + reach; ++y) {
      for (std::int32_t x = c.x - reach; x <= c.x + reach; ++x) {
        const std::int32_t number = find(x, y);
        if (number >= 0) visit(number);
      }
    }
  }

 private:
  TilePlane<std::int32_t, 6> numbers_;  ///< from 1 on
  std::vector<PlaneCell> cells_;
};

/// The cells that belong(number), in pieces that touch one another, be it at a corner: each lists
/// its cells from the first one on.
template <class Belongs>
std::vector<std::vector<std::int32_t>> connectedCells(const CellIndex& index, Belongs&& belongs) {
  std::vector<std::vector<std::int32_t>> pieces;
  std::vector<std::uint8_t> is_taken(index.size(), 0);
  const auto take = [&](std::int32_t cell, std::vector<std::int32_t>& piece) {
    if (is_taken[cell] || !belongs(cell)) return;
    is_taken[cell] = 1;
    piece.push_back(cell);
  };
  for (std::size_t start = 0; start < index.size(); ++start) {
    std::vector<std::int32_t> piece;
    take(static_cast<std::int32_t>(start), piece);
    for (std::size_t k = 0; k < piece.size(); ++k)
      index.forAround(piece[k], 1, [&](std::int32_t cell) { take(cell, piece); });
    if (!piece.empty()) pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// Numbers of items by the group they belong to, in their order within each: those of group g are
/// order[starts[g]] to order[starts[g + 1]].
struct Grouped {
  std::vector<std::size_t> starts;  ///< of each group, and the end
  std::vector<std::uint32_t> order;

  /// `group_of`: of each item; -1 = of none.
  Grouped(const std::vector<std::int32_t>& group_of, std::size_t groups) : starts(groups + 1, 0) {
    for (const std::int32_t g : group_of) {
      if (g >= 0) ++starts[static_cast<std::size_t>(g) + 1];
    }
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::size_t> next = starts;
    order.resize(starts.back());
    for (std::size_t i = 0; i < group_of.size(); ++i) {
      if (group_of[i] >= 0) order[next[group_of[i]]++] = static_cast<std::uint32_t>(i);
    }
  }
};

/// Heights of the ground at the middles of square cells, bilinear in between [m].
struct HeightLattice {
  float side_m;
  CellIndex index;
  std::vector<float> heights;  ///< by number of the cell; NaN where nothing is known yet

  std::int32_t cellAt(float x, float y) const {  ///< or -1
    return index.find(floorToInt(x / side_m), floorToInt(y / side_m));
  }

  /// Spreads heights to the cells without one, nearest first (breadth first), up to `reach` cells
  /// further each time; what is out of reach gets the median.
  void fillGaps(std::int32_t reach);

  float heightAt(float x, float y) const {
    const float fx = x / side_m - 0.5f, fy = y / side_m - 0.5f;
    const std::int32_t ix = floorToInt(fx), iy = floorToInt(fy), own = cellAt(x, y);
    const float rx = fx - static_cast<float>(ix), ry = fy - static_cast<float>(iy);
    const auto at = [&](std::int32_t cx, std::int32_t cy) {
      const std::int32_t i = index.find(cx, cy);
      return i >= 0 ? heights[i] : own >= 0 ? heights[own] : 0;
    };
    return (at(ix, iy) * (1 - rx) + at(ix + 1, iy) * rx) * (1 - ry) +
           (at(ix, iy + 1) * (1 - rx) + at(ix + 1, iy + 1) * rx) * ry;
  }
};

/// Disjoint sets of numbers, each named by its smallest one. With path halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size = 0) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  /// A set of its own for the next number.
  void add() { parent_.push_back(static_cast<std::uint32_t>(parent_.size())); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace xview
