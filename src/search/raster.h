// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "xview/base/localization.h"

namespace xview::search {

constexpr const char* kSearchStage = "the search";  ///< to a budget

constexpr int kTileBits = 6;
constexpr int kTileSide = 1 << kTileBits;
constexpr int kPartSide = 8;  ///< cells of the blocks that Tile::differs tells of
constexpr int kParts = kTileSide / kPartSide;

/// One byte per cell and channel on an unbounded plane, in 64x64-cell tiles that exist only where
/// something was written: a road network costs its streets, not its bounding box. Cells without a
/// tile have the channel's background value.
class LikelihoodRaster {
 public:
  /// At most 4096 channels; cell_m > 0 [m]. Throws UsageError otherwise.
  LikelihoodRaster(double cell_m, std::vector<std::uint8_t> background_of_channel);

  LikelihoodRaster(LikelihoodRaster&&) = default;
  LikelihoodRaster& operator=(LikelihoodRaster&&) = default;

  /// Of no other raster of this process.
  std::uint64_t id() const { return id_; }
  double cellSize() const { return cell_m_; }
  std::size_t channels() const { return background_.size(); }
  std::uint8_t background(std::size_t channel) const { return background_.at(channel); }
  /// Cell (cx, cy) covers [cx, cx + 1) x [cy, cy + 1) times cellSize().
  void set(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);
  /// Keeps the larger of the old and the new value.
  void raise(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);
  std::uint8_t at(std::size_t channel, std::int32_t cx, std::int32_t cy) const;

  struct Tile {
    std::int32_t tx, ty;  ///< cell (cx, cy) is in tile (cx >> 6, cy >> 6)
    std::uint16_t channel;
    std::uint8_t highest;  ///< no cell of the tile is above this
    std::uint64_t
        differs;  ///< bit 8 * (y / 8) + x / 8: that 8x8 block may differ from the background
    std::array<std::uint8_t, kTileSide * kTileSide> cells;  ///< row-major
  };
  const std::deque<Tile>& tiles() const { return tiles_; }
  /// In place of the one that is there. Throws std::out_of_range for a channel that does not exist.
  void add(const Tile& tile);
  /// The tiles of one place by channel; null where nothing was written.
  using Place = std::vector<Tile*>;
  /// Null if no channel has a tile there.
  const Place* findPlace(std::int64_t tx, std::int64_t ty) const;
  static const Tile* tileOf(const Place* place, std::size_t channel) {
    return place && channel < place->size() ? (*place)[channel] : nullptr;
  }

 private:
  const Tile* find(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
    return tileOf(findPlace(cx >> kTileBits, cy >> kTileBits), channel);
  }
  std::uint8_t& make(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);

  std::uint64_t id_;
  double cell_m_;
  std::vector<std::uint8_t> background_;
  std::deque<Tile> tiles_;  ///< in order of creation; addresses are stable
  std::unordered_map<std::uint64_t, Place> places_;
  Tile* last_written_ = nullptr;
};

/// A query sample, relative to the centre of the query, in metres.
struct RasterSample {
  float x = 0, y = 0;
  std::uint16_t channel = 0;
};

/// A raster of a place with samples of a query for it. A finer raster of the same place has its own
/// samples of the same query (thicker, if evidence per square metre should stay the same).
struct RasterLevel {
  const LikelihoodRaster& raster;
  std::vector<RasterSample> samples;
  double max_yaw_step_rad = 0.105;  ///< 6 degrees; smaller if the query is large
  /// Of a fine raster that is written where it is looked at only: called before a square of cells
  /// is read, writes what is missing of it; what it returns is held while the cells are read.
  std::function<std::unique_lock<std::mutex>(std::int64_t x, std::int64_t y, std::int64_t side)>
      write_first = {};
};

/// What one query is searched with, and how much of it is kept.
struct RasterLevels {
  RasterLevel fine;
  /// The first look at large maps: the best of its cells are looked at again on the fine raster
  /// (all fine cells and yaws that a coarse cell stands for). Its cells are a whole multiple of the
  /// fine ones.
  std::optional<RasterLevel> coarse;
  /// The query centre is looked for this close to cells above the background only (up to 16 cells
  /// more). Saves time where the centre cannot be far from the map's content; the default looks
  /// wherever a sample can score.
  double margin_m = std::numeric_limits<double>::infinity();
  std::size_t keep_cells = 4000;  ///< best (x, y, yaw) cells kept before thinning
  /// Coarse cells below this share of the best score are not looked at on the fine raster, nor
  /// those below `clear_share` if they are not among the first few.
  double least_share = 0, clear_share = 0;
  std::size_t few_cells = 0;
  std::size_t keep_poses = 200;  ///< distinct poses returned
  /// The first of them that are refined. Of the others half as many are, the best by a rough
  /// refinement: the cell of a true pose may have a bad score.
  std::size_t refine_poses = 200;
  int threads = 1;
  PlacePrior centre_prior = {};  ///< restricts the pose of the query centre

  const RasterLevel& first() const { return coarse ? *coarse : fine; }
};

/// Exhaustive search over (x, y, yaw): the score of a pose is the sum over samples of the raster
/// value of their channel at the transformed sample minus the background of the channel (so that
/// unseen area counts zero). Returns the best distinct poses of positive score (non-maximum
/// suppression within 1.6 cells and 1.6 yaw steps), best first; ties are broken by position, so
/// that neither threads nor the instruction set matter. Positions are cell centres;
/// PlacePose::score is that integer sum, on the fine raster. Time grows with the area near written
/// tiles, the number of samples and the query radius (finer yaw); at most 2000 cells of radius are
/// possible. Throws UsageError for samples that are farther, not finite, or of an unknown channel.
std::vector<PlacePose> searchRaster(const RasterLevels& levels);

constexpr int kBlock = 64;  ///< columns of a block; also the side of a tile

/// A cell of the block whose sum reached the threshold.
struct BlockHit {
  std::uint16_t row, column;
  std::uint32_t sum;
};

/// Sums of one byte per sample for every cell of a block of up to 64 rows of 64 cells.
struct BlockScan {
  const std::uint8_t* const*
      samples;  ///< what each sample adds to row 0, column 0; further cells follow by stride
  const std::uint32_t*
      groups;  ///< group g is samples [groups[g], groups[g + 1]); no sum of a group exceeds 255
  std::size_t group_count;
  std::ptrdiff_t stride;    ///< bytes between rows
  int rows;                 ///< 1 to 64
  std::uint32_t threshold;  ///< cells with a sum of at least this are reported; at least 1
};

/// Writes the hits in row-major order (room for rows * 64 of them) and returns their number.
std::size_t scanBlock(const BlockScan& scan, BlockHit* hits);

}  // namespace xview::search
