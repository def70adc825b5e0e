// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "distribution_table.h"
#include "viewpoints.h"
#include "xview/pose/refine.h"
#include "xview/types/labels.h"

namespace xview {

constexpr std::uint32_t kNoGroup = 0xFFFFFFFF;

/// Points match within a group: a kind of thing, or one class if its kind is not known. Lane
/// markings lie on the road. kNoGroup for what moves and what is ignored.
std::uint32_t matchingGroup(const LabelSet& labels, std::uint32_t label);
/// Of a group; none for a class of its own.
Kind kindOf(std::uint32_t group);

/// The distributions of a map, made tile by tile where they are asked for. What a tile holds
/// depends on the map alone, so neither the order of the questions nor threads change an answer.
class DistributionCells {
 public:
  /// The cloud must outlive the cells.
  DistributionCells(const LabelledCloud& map, const LabelSet& labels,
                    const std::vector<Eigen::Isometry3d>& viewpoints, const RefineOptions& options);
  ~DistributionCells();
  DistributionCells(const DistributionCells&) = delete;
  DistributionCells& operator=(const DistributionCells&) = delete;

  static const DistributionCells& of(const DistributionMap& map) { return *map.cells_; }

  const Eigen::Vector3d& origin() const { return map_.origin; }
  /// The nearest distribution of the group in the cell of p and the 26 around it, within the gate.
  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate) const;
  std::size_t size() const;                ///< of all tiles, which it makes
  double noise() const { return noise_; }  ///< by which looks at one surface err as a whole [m]

 private:
  /// The points [first, last) of the cloud.
  struct Run {
    std::uint32_t first, last;
  };
  /// A column of the map, so many cells wide that none lies in two.
  struct Tile {
    std::int32_t x, y;
    std::vector<Run> runs;
    mutable std::atomic<const DistributionTable*> table{nullptr};  ///< null: not made yet
    Tile(std::int32_t tile_x, std::int32_t tile_y) : x(tile_x), y(tile_y) {}
    ~Tile() { delete table.load(); }
  };

  template <class Visit>
  void forPoints(const Run& run, Visit&& visit) const;
  void sortIntoTiles();
  float typicalThickness() const;
  std::size_t slotOf(std::int32_t x, std::int32_t y) const;
  Tile& findOrAddTile(std::int32_t x, std::int32_t y);
  DistributionTable makeTable(const Tile& tile) const;
  const DistributionTable& tableOf(const Tile& tile) const;
  const DistributionTable* tableAt(std::int32_t x, std::int32_t y) const;  ///< null: no points

  const LabelledCloud& map_;
  const LabelSet labels_;
  const Viewpoints views_;
  const float side_;
  float noise_ = 0;     ///< [m]
  float variance_ = 0;  ///< added to every distribution [m^2]
  std::deque<Tile> tiles_;
  std::vector<std::int32_t> slots_ = std::vector<std::int32_t>(64, -1);  ///< hash table of tiles
};

}  // namespace xview
