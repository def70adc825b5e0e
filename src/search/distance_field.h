// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/cells.h"
#include "base/stored_view.h"
#include "search/likelihoods.h"
#include "xview/base/bev_grid.h"

namespace xview::search {

/// All tiles of a large map, seen from afar (DistanceField::overview).
struct MapOverview {
  static constexpr int kSide = 8;              ///< squares along a tile
  static constexpr std::size_t kFewest = 400;  ///< tiles; smaller maps have none
  struct Tile {
    PlaneCell at;
    std::vector<std::uint8_t> squares;
  };
  std::vector<Tile> tiles;     ///< sorted by (y, x)
  std::uint64_t checksum = 0;  ///< checksumOf() the view, if that is known
};

/// For every cell of a map and every channel: the class of the distance to the nearest sample.
/// Tiles of 64x64 cells that exist only where the map was seen; a tile depends only on samples
/// within 9 m of it and is made when it is first asked for. Cells within 1 m of a seen one count as
/// seen; other cells are unknown unless a sample is nearer than 2 m. Thread-safe.
class DistanceField {
 public:
  static constexpr int kTileCells = 64;
  static constexpr double kRim_m = 10;  ///< what a tile is made of lies this near to it [m]

  explicit DistanceField(const BevGrid& map);
  /// Of a stored view, whose columns are read where they are asked for. `grid`: without samples, of
  /// the cells that fitsColumns() allows; `tiles`: all that exist. Making a tile may throw Error.
  DistanceField(const BevGrid& grid, std::shared_ptr<const StoredView> stored,
                const MapOverview& tiles);
  /// Whether tiles lie in one column of a stored view each.
  static bool fitsColumns(double cell_m);
  ~DistanceField();
  DistanceField(DistanceField&&) noexcept;

  double cellSize() const { return cell_m_; }
  double originX() const { return origin_x_; }
  double originY() const { return origin_y_; }

  /// One tile: a plane of classes per channel, and the ground.
  struct Tile {
    std::int32_t x = 0, y = 0;  ///< tile index; its first cell is (x, y) * kTileCells
    std::array<const std::uint8_t*, kBevChannels> bins{};
    /// Height per cell relative to the plan's origin; NaN where not measured.
    std::vector<float> ground;
    /// Mean height of the seen cells, measured or taken from what stands around; NaN if none is.
    float level = std::numeric_limits<float>::quiet_NaN();
  };
  /// Those where the map was seen.
  const std::vector<PlaneCell>& tiles() const { return tiles_; }
  /// Makes all tiles that are not made yet.
  void makeAll(int threads) const;

  /// A tile seen from afar: of `side` x `side` squares, channel by channel and row by row, the
  /// class of the nearest of its cells in the low four bits and the median one in the high ones.
  /// From cells of twice the size, with one sample per cell; `side`: at most 32, a power of two.
  std::vector<std::uint8_t> overview(const PlaneCell& tile, int side) const;

  /// The tile of cell (cx, cy), or null where the map was never seen.
  const Tile* tileOfCell(std::int32_t cx, std::int32_t cy) const {
    const std::int32_t number = places_.find({cx >> 6, cy >> 6});
    return number < 0 ? nullptr : tile(static_cast<std::size_t>(number));
  }
  static std::size_t cellInTile(std::int32_t cx, std::int32_t cy) {
    return static_cast<std::size_t>(cy & 63) * kTileCells + static_cast<std::size_t>(cx & 63);
  }
  /// Class at a cell; kUnknownBin where the map was never seen.
  std::uint8_t bin(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
    const Tile* tile = tileOfCell(cx, cy);
    return tile ? tile->bins[channel][cellInTile(cx, cy)] : static_cast<std::uint8_t>(kUnknownBin);
  }
  /// The same at a place in plan coordinates [m].
  std::uint8_t binAt(std::size_t channel, double x, double y) const {
    return bin(channel, static_cast<std::int32_t>(std::floor(x / cell_m_)),
               static_cast<std::int32_t>(std::floor(y / cell_m_)));
  }

 private:
  struct Site;
  struct Column;
  struct Place;
  struct PlaceNumber {
    PlaneCell key;
  };
  using Sites = std::array<std::vector<Site>, kBevChannels>;

  Place& placeOf(const PlaneCell& tile);
  Place* find(const PlaneCell& tile) const {
    const std::int32_t number = places_.find(tile);
    return number < 0 ? nullptr : all_[static_cast<std::size_t>(number)].get();
  }
  /// The same with what its column holds.
  Place* findRead(const PlaneCell& tile) const;
  /// place(tile) is null where something does not belong.
  template <class PlaceFor>
  void distribute(const BevGrid& part, const PlaceFor& place) const;
  const Tile* tile(std::size_t number) const;
  void make(Place& place) const;
  std::array<std::uint64_t, kTileCells> seenIn(const PlaneCell& tile) const;
  Sites sitesAround(const PlaneCell& tile) const;

  double cell_m_ = 0.5, origin_x_ = 0, origin_y_ = 0;
  std::shared_ptr<const StoredView> stored_;
  std::vector<PlaneCell> tiles_;
  std::vector<std::unique_ptr<Column>> columns_;
  /// With what was seen or sampled there; tiles are made of it.
  std::vector<std::unique_ptr<Place>> all_;
  CellTable<PlaceNumber> places_;  ///< of all_
};

/// Of samples and seen cells, in their order.
std::uint64_t checksumOf(const BevGrid& view);

/// All tiles of a field seen from afar, with `side` x `side` squares each; without a checksum.
MapOverview overviewOf(const DistanceField& field, int side, int threads);
/// That of a large map with cells that fitsColumns() allows; null of other maps.
std::shared_ptr<const MapOverview> overviewOfLarge(const BevGrid& map);
/// The same of a map that has grown by `addition`, from the overview that it had before. Of the map
/// only what lies within grownReach() of the addition is looked at.
std::shared_ptr<const MapOverview> grownOverview(const MapOverview& before, const BevGrid& map,
                                                 const BevGrid& addition);
double grownReach(double cell_m);  ///< [m]

/// Tells a view from others by how many samples of each channel it has (PathNull::view).
std::uint64_t fingerprintOf(const BevGrid& map);
/// That of a view which has what two others have.
std::uint64_t fingerprintOfSum(std::uint64_t a, std::uint64_t b);

/// Puts what lies within 30 m of one sensor position at another one at least 25 m away, heading
/// aligned or reversed, and counts. In a town of equal streets a generic street fits everywhere;
/// likelihoods learned elsewhere do not know that. `path`: sensor positions from the origin of the
/// grid. All zero if the path is too short to say anything. Of a path that has grown only poses
/// from or to its new part are drawn, in proportion, and added to `known`; if the view is another
/// one and the path is not longer, all is counted anew. `known` itself if it stands for this view.
/// `stored`: what a `map` without samples has, if it is packed.
PathNull mapNull(const BevGrid& map, const std::vector<Eigen::Vector2d>& path,
                 const DistanceField& field, const PathNull& known = {},
                 const StoredView* stored = nullptr);

}  // namespace xview::search
