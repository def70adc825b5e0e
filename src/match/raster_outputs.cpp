// SPDX-License-Identifier: BSD-3-Clause
#include "raster_outputs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace xview::raster {
namespace {

using Tiles = LikelihoodRaster::Tiles;
using TilePlace = std::pair<std::int64_t, std::int64_t>;  // ty, tx

/// Where any channel of the query differs from its background, in parts of 8x8 cells.
class Content {
 public:
  Content(const Tiles& tiles, const std::vector<std::uint16_t>& channels) {
    for (const Tiles::Tile& tile : tiles.tiles) {
      if (tile.differs == 0 || !std::binary_search(channels.begin(), channels.end(), tile.channel))
        continue;
      parts_of_tile_[{tile.ty, tile.tx}] |= tile.differs;
    }
  }

  /// Tiles within `reach` tiles of one with content, sorted.
  std::vector<TilePlace> tilesWithin(std::int64_t reach) const {
    std::vector<TilePlace> tiles;
    for (const auto& [place, parts] : parts_of_tile_) {
      for (std::int64_t y = place.first - reach; y <= place.first + reach; ++y) {
        for (std::int64_t x = place.second - reach; x <= place.second + reach; ++x)
          tiles.emplace_back(y, x);
      }
    }
    std::sort(tiles.begin(), tiles.end());
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
    return tiles;
  }

  /// Rows of a tile, in bands of 8, that are within `reach` cells of content.
  std::vector<RowRun> rowsNear(const TilePlace& tile, std::int64_t reach) const {
    const std::int64_t parts = (reach + kPartSide - 1) / kPartSide,
                       tiles = (parts + kParts - 1) / kParts;
    std::uint32_t bands = 0;
    for (std::int64_t dy = -tiles; dy <= tiles && bands != 0xFF; ++dy) {
      for (std::int64_t dx = -tiles; dx <= tiles; ++dx) {
        const auto it = parts_of_tile_.find({tile.first + dy, tile.second + dx});
        if (it == parts_of_tile_.end()) continue;
        for (std::int64_t row = 0; row < kParts; ++row) {
          if (rowReaches(it->second, row, dx, parts))
            bands |= bandsAround(dy * kParts + row, parts);
        }
      }
    }
    return runsOf(bands);
  }

 private:
  /// True if one of the parts of a row in the tile dx beside is near enough in x.
  static bool rowReaches(std::uint64_t content, std::int64_t row, std::int64_t dx,
                         std::int64_t parts) {
    for (std::int64_t column = 0; column < kParts; ++column) {
      const std::int64_t x = dx * kParts + column;
      if ((content >> (row * kParts + column) & 1) && x >= -parts && x < kParts + parts)
        return true;
    }
    return false;
  }

  static std::uint32_t bandsAround(std::int64_t row, std::int64_t parts) {
    std::uint32_t bands = 0;
    const std::int64_t last = std::min<std::int64_t>(kParts - 1, row + parts);
    for (std::int64_t b = std::max<std::int64_t>(0, row - parts); b <= last; ++b) bands |= 1u << b;
    return bands;
  }

  static std::vector<RowRun> runsOf(std::uint32_t bands) {
    std::vector<RowRun> runs;
    for (int b = 0; b < kParts; ++b) {
      if (!(bands >> b & 1)) continue;
      if (b > 0 && (bands >> (b - 1) & 1)) {
        runs.back().count += kPartSide;
      } else {
        runs.push_back({b * kPartSide, kPartSide});
      }
    }
    return runs;
  }

  std::map<TilePlace, std::uint64_t> parts_of_tile_;
};

bool touchesCircle(const TilePlace& tile, const PlacePrior::Circle& circle, double cell_m) {
  const double side = cell_m * kTileSide;
  const double x0 = static_cast<double>(tile.second) * side,
               y0 = static_cast<double>(tile.first) * side;
  const double dx = circle.x - std::clamp(circle.x, x0, x0 + side),
               dy = circle.y - std::clamp(circle.y, y0, y0 + side);
  return std::hypot(dx, dy) <= circle.radius + cell_m;
}

/// Each channel contributes at most its number of samples times the largest rise over the
/// background in reach.
std::int64_t scoreBound(const Tiles& tiles, const PreparedSamples& prepared, const TilePlace& place,
                        std::int64_t reach_tiles) {
  std::vector<std::uint8_t> highest = prepared.background;
  for (std::int64_t y = place.first - reach_tiles; y <= place.first + reach_tiles; ++y) {
    for (std::int64_t x = place.second - reach_tiles; x <= place.second + reach_tiles; ++x) {
      const Tiles::Place* near = tiles.findPlace(x, y);
      if (!near) continue;
      for (std::size_t slot = 0; slot < highest.size(); ++slot) {
        const Tiles::Tile* tile = Tiles::tileOf(near, prepared.channels[slot]);
        if (tile) highest[slot] = std::max(highest[slot], tile->highest);
      }
    }
  }
  std::int64_t bound = 0;
  for (std::size_t slot = 0; slot < highest.size(); ++slot) {
    bound += static_cast<std::int64_t>(prepared.count[slot]) *
             (highest[slot] - prepared.background[slot]);
  }
  return bound;
}

}  // namespace

std::vector<OutputTile> outputTiles(const LikelihoodRaster& raster, const PreparedSamples& prepared,
                                    const RasterSearchOptions& options) {
  const Content content(raster.tiles(), prepared.channels);
  const double margin = std::max(0.0, std::ceil(options.margin_m / raster.cellSize()));
  const std::int64_t reach = margin < static_cast<double>(prepared.reach)
                                 ? static_cast<std::int64_t>(margin)
                                 : prepared.reach;
  const std::int64_t sample_tiles = (prepared.reach + kTileSide - 1) / kTileSide;
  std::vector<OutputTile> outputs;
  for (const TilePlace& place : content.tilesWithin((reach + kTileSide - 1) / kTileSide)) {
    const auto& near = options.centre_prior.near;
    if (near && !touchesCircle(place, *near, raster.cellSize())) continue;
    std::vector<RowRun> rows = content.rowsNear(place, reach);
    if (rows.empty()) continue;
    const std::int64_t bound = scoreBound(raster.tiles(), prepared, place, sample_tiles);
    if (bound > 0) outputs.push_back({place.second, place.first, bound, std::move(rows)});
  }
  std::stable_sort(outputs.begin(), outputs.end(),
                   [](const OutputTile& a, const OutputTile& b) { return a.bound > b.bound; });
  return outputs;
}

}  // namespace xview::raster
