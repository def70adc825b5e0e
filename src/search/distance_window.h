// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace xview::search {

/// Distances from the cells of a tile to the nearest of a set of sites. All lengths are in cells;
/// the first cell of the tile spans [0, 1) x [0, 1) and is measured from its centre.
class DistanceWindow {
 public:
  static constexpr int kSide = 64;

  struct Site {
    float x, y;
  };
  using Distances = std::array<float, kSide * kSide>;

  /// Sites further than `reach` from the tile are left out, and distances above it are only known
  /// to be above it.
  explicit DistanceWindow(float reach);
  float reach() const { return reach_; }
  /// Squared distances by row and column. Few sites are tried one by one; many are handed on from
  /// cell to cell, which may miss the nearest one for another that is further by less than a
  /// hundredth of a cell.
  const Distances& squared(const std::vector<Site>& sites);

  /// Per cell, how many of the limits (squared as well) its distance reaches.
  static void countReached(const Distances& squared, const std::vector<float>& limits,
                           std::uint8_t* counts);

 private:
  /// The site nearest to each cell of the window, in lines of cells with a border of cells without
  /// a site.
  struct Lines {
    std::vector<float> along, across;  ///< coordinates of the site along and across the lines
  };
  void placeSites(const std::vector<Site>& sites);
  void takeFrom(const Lines& lines, bool transposed);

  float reach_;
  int margin_, width_, stride_;
  Lines rows_, columns_;
  Distances squared_;
};

}  // namespace xview::search
