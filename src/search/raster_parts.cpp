// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "base/pose.h"
#include "xview/base/error.h"

namespace xview::search {

namespace {

constexpr double kMaxRadiusCells = 2000;
constexpr double kSuppressed_cells = 1.6, kSuppressed_yaw_steps = 1.6;  // by a better candidate
constexpr int kPartBits = 3;
static_assert(1 << kPartBits == kPartSide, "parts are found by shifts");
constexpr double kDenseShare = 0.6;  // of the parts of a layer that differ from the background

/// Largest distance of a sample from the centre [m].
double radiusOf(const std::vector<RasterSample>& samples) {
  double radius = 0;
  for (const RasterSample& s : samples) radius = std::max(radius, std::hypot<double>(s.x, s.y));
  return radius;
}

}  // namespace

void check(const RasterLevel& level) {
  const LikelihoodRaster& raster = level.raster;
  for (const RasterSample& s : level.samples) {
    if (s.channel >= raster.channels()) {
      throw UsageError("raster search: sample of channel " + std::to_string(s.channel) +
                       ", the raster has " + std::to_string(raster.channels()));
    }
    const double cells = std::hypot<double>(s.x, s.y) / raster.cellSize();
    if (!(cells <= kMaxRadiusCells)) {
      throw UsageError("raster search: a sample is " + std::to_string(cells) +
                       " cells from the centre, at most 2000 are possible; use larger cells");
    }
  }
}

double yawStep(const RasterLevel& level) {
  return std::min(level.max_yaw_step_rad,
                  1.2 * level.raster.cellSize() / std::max(10.0, 0.7 * radiusOf(level.samples)));
}

YawGrid yawGrid(double wanted_step, const std::optional<PlacePrior::Heading>& prior) {
  if (prior && prior->tolerance < M_PI) {
    const int half = static_cast<int>(std::ceil(std::max(0.0, prior->tolerance) / wanted_step));
    const double step = half > 0 ? prior->tolerance / half : wanted_step;
    return {prior->yaw - half * step, step, 2 * half + 1};
  }
  const int count = std::max(1, static_cast<int>(std::ceil(2 * M_PI / wanted_step)));
  return {0, 2 * M_PI / count, count};
}

PreparedSamples::PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted)
    : samples(std::move(unsorted)) {
  std::stable_sort(
      samples.begin(), samples.end(),
      [](const RasterSample& a, const RasterSample& b) { return a.channel < b.channel; });
  for (const RasterSample& s : samples) {
    if (channels.empty() || channels.back() != s.channel) {
      channels.push_back(s.channel);
      background.push_back(raster.background(s.channel));
      count.push_back(0);
    }
    slot.push_back(static_cast<std::uint32_t>(channels.size() - 1));
    ++count.back();
    background_sum += background.back();
  }
  reach = static_cast<std::int64_t>(std::ceil(radiusOf(samples) / raster.cellSize())) + 1;
}

std::vector<CellOffset> offsetTable(const PreparedSamples& prepared, const YawGrid& grid,
                                    double cell_m) {
  std::vector<CellOffset> table;
  table.reserve(static_cast<std::size_t>(grid.count) * prepared.size());
  const auto cell = [&](double v) {
    return static_cast<std::int32_t>(std::floor(v / cell_m + 0.5 + kRoundingSlack));
  };
  for (int i = 0; i < grid.count; ++i) {
    const double c = std::cos(grid.yaw(i)), s = std::sin(grid.yaw(i));
    for (const RasterSample& q : prepared.samples)
      table.push_back({cell(c * q.x - s * q.y), cell(s * q.x + c * q.y)});
  }
  return table;
}

void BestCandidates::merge(const BestCandidates& other) {
  for (const Candidate& candidate : other.candidates_) offer(candidate);
}

std::vector<Candidate> BestCandidates::sorted() && {
  prune();
  std::sort(candidates_.begin(), candidates_.end());
  return std::move(candidates_);
}

void BestCandidates::prune() {
  if (candidates_.size() <= keep_) return;
  const auto last = candidates_.begin() + static_cast<std::ptrdiff_t>(keep_ - 1);
  std::nth_element(candidates_.begin(), last, candidates_.end());
  threshold_ = std::max(threshold_, last->score);
  candidates_.resize(keep_);
}

std::vector<PlacePose> distinctPoses(const std::vector<Candidate>& candidates, const YawGrid& grid,
                                     double cell_m, std::size_t keep) {
  std::vector<PlacePose> poses;
  std::vector<Candidate> kept;
  const auto isSuppressed = [&](const Candidate& c) {
    return std::any_of(kept.begin(), kept.end(), [&](const Candidate& k) {
      const auto dx = static_cast<double>(k.x - c.x), dy = static_cast<double>(k.y - c.y);
      return dx * dx + dy * dy < kSuppressed_cells * kSuppressed_cells &&
             std::abs(angleDifference(grid.yaw(k.yaw), grid.yaw(c.yaw))) <
                 kSuppressed_yaw_steps * grid.step;
    });
  };
  for (const Candidate& c : candidates) {
    if (poses.size() >= keep) break;
    if (isSuppressed(c)) continue;
    kept.push_back(c);
    poses.push_back({(static_cast<double>(c.x) + 0.5) * cell_m,
                     (static_cast<double>(c.y) + 0.5) * cell_m, angleDifference(grid.yaw(c.yaw), 0),
                     static_cast<double>(c.score)});
  }
  return poses;
}

Window::Window(const LikelihoodRaster& raster, const PreparedSamples& prepared, std::int64_t side)
    : raster_(raster),
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
      const LikelihoodRaster::Place* place = raster_.findPlace(tx, ty);
      for (std::size_t slot = 0; slot < prepared_.channels.size(); ++slot) {
        const LikelihoodRaster::Tile* tile =
            LikelihoodRaster::tileOf(place, prepared_.channels[slot]);
        copyTile(slot, tile, tx, ty);
        if (tile) noteTile(slot, *tile);
      }
    }
  }
  for (std::size_t slot = 0; slot < prepared_.channels.size(); ++slot) countParts(slot);
}

/// Marks the parts of the window that the tile fills, one right and below of their place.
void Window::noteTile(std::size_t slot, const LikelihoodRaster::Tile& tile) {
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

void Window::copyTile(std::size_t slot, const LikelihoodRaster::Tile* tile, std::int64_t tx,
                      std::int64_t ty) {
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

namespace {

using TilePlace = std::pair<std::int64_t, std::int64_t>;  // ty, tx

/// Where any channel of the query differs from its background, in parts of 8x8 cells.
class Content {
 public:
  Content(const LikelihoodRaster& raster, const std::vector<std::uint16_t>& channels) {
    for (const LikelihoodRaster::Tile& tile : raster.tiles()) {
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
std::int64_t scoreBound(const LikelihoodRaster& raster, const PreparedSamples& prepared,
                        const TilePlace& place, std::int64_t reach_tiles) {
  std::vector<std::uint8_t> highest = prepared.background;
  for (std::int64_t y = place.first - reach_tiles; y <= place.first + reach_tiles; ++y) {
    for (std::int64_t x = place.second - reach_tiles; x <= place.second + reach_tiles; ++x) {
      const LikelihoodRaster::Place* near = raster.findPlace(x, y);
      if (!near) continue;
      for (std::size_t slot = 0; slot < highest.size(); ++slot) {
        const LikelihoodRaster::Tile* tile =
            LikelihoodRaster::tileOf(near, prepared.channels[slot]);
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
                                    const RasterLevels& levels) {
  const Content content(raster, prepared.channels);
  const double margin = std::max(0.0, std::ceil(levels.margin_m / raster.cellSize()));
  const std::int64_t reach = margin < static_cast<double>(prepared.reach)
                                 ? static_cast<std::int64_t>(margin)
                                 : prepared.reach;
  const std::int64_t sample_tiles = (prepared.reach + kTileSide - 1) / kTileSide;
  std::vector<OutputTile> outputs;
  for (const TilePlace& place : content.tilesWithin((reach + kTileSide - 1) / kTileSide)) {
    const auto& near = levels.centre_prior.near;
    if (near && !touchesCircle(place, *near, raster.cellSize())) continue;
    std::vector<RowRun> rows = content.rowsNear(place, reach);
    if (rows.empty()) continue;
    const std::int64_t bound = scoreBound(raster, prepared, place, sample_tiles);
    if (bound > 0) outputs.push_back({place.second, place.first, bound, std::move(rows)});
  }
  std::stable_sort(outputs.begin(), outputs.end(),
                   [](const OutputTile& a, const OutputTile& b) { return a.bound > b.bound; });
  return outputs;
}

}  // namespace xview::search
