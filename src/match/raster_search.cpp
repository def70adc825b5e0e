// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/raster_search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <thread>
#include <tuple>
#include <unordered_map>

#include "raster_kernel.h"
#include "raster_tiles.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

using Tiles = LikelihoodRaster::Tiles;

constexpr double kPi = 3.14159265358979323846;
constexpr std::int64_t kMaxRadiusCells = 2000;
constexpr double kRoundingSlack =
    1e-6;  // [cells] makes exact halves round up in spite of rounding errors

/// Side of the square of output cells that one window serves.
constexpr std::int64_t kBlockSide = raster::kBlock;
static_assert(raster::kBlock == kTileSide, "output blocks are tiles");

double radiusOf(const std::vector<RasterSample>& samples) {
  double radius = 0;
  for (const RasterSample& s : samples) radius = std::max(radius, std::hypot<double>(s.x, s.y));
  return radius;
}

void check(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples) {
  for (const RasterSample& s : samples) {
    if (s.channel >= raster.channels()) {
      throw UsageError("raster search: sample of channel " + std::to_string(s.channel) +
                       ", the raster has " + std::to_string(raster.channels()));
    }
    const double cells = std::hypot<double>(s.x, s.y) / raster.cellSize();
    if (!(cells <= kMaxRadiusCells)) {
      throw UsageError("raster search: a sample is " + std::to_string(cells) +
                       " cells from the centre, at most " + std::to_string(kMaxRadiusCells) +
                       " are possible; use larger cells");
    }
  }
}

/// The cell of a sample relative to the cell of the query centre.
struct CellOffset {
  std::int64_t x, y;
};

CellOffset cellOffset(const RasterSample& s, double cosine, double sine, double cell_m) {
  return {static_cast<std::int64_t>(
              std::floor((cosine * s.x - sine * s.y) / cell_m + 0.5 + kRoundingSlack)),
          static_cast<std::int64_t>(
              std::floor((sine * s.x + cosine * s.y) / cell_m + 0.5 + kRoundingSlack))};
}

/// Evenly spaced headings: the circle, or the tolerance around the expected one.
struct YawGrid {
  double first = 0, step = 0;
  int count = 0;
  double yaw(int index) const { return first + index * step; }
};

/// A sample at 70 % of the query radius moves by at most 1.2 cells from one heading to the next.
double yawStep(double max_step, double cell_m, double radius_m) {
  return std::min(max_step, 1.2 * cell_m / std::max(10.0, 0.7 * radius_m));
}

YawGrid yawGrid(double wanted_step, const std::optional<PlacePrior::Heading>& prior) {
  if (prior && prior->tolerance < kPi) {
    const int half = static_cast<int>(std::ceil(std::max(0.0, prior->tolerance) / wanted_step));
    const double step = half > 0 ? prior->tolerance / half : wanted_step;
    return {prior->yaw - half * step, step, 2 * half + 1};
  }
  const int count = std::max(1, static_cast<int>(std::ceil(2 * kPi / wanted_step)));
  return {0, 2 * kPi / count, count};
}

/// Samples prepared for sums of bytes: sorted by channel, in groups that cannot exceed 255.
struct PreparedSamples {
  std::vector<RasterSample> samples;
  std::vector<std::uint16_t> channels;  ///< the different ones, rising
  std::vector<std::uint32_t> slot;      ///< per sample: index of its channel in `channels`
  std::vector<std::uint32_t> count;     ///< per slot: number of samples
  std::vector<std::uint32_t> groups;
  std::int64_t background = 0;  ///< sum of the backgrounds
  std::int64_t reach = 0;       ///< largest possible offset [cells]

  PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted);
};

PreparedSamples::PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted)
    : samples(std::move(unsorted)) {
  std::stable_sort(
      samples.begin(), samples.end(),
      [](const RasterSample& a, const RasterSample& b) { return a.channel < b.channel; });
  int in_group = 256;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const std::uint16_t channel = samples[i].channel;
    if (channels.empty() || channels.back() != channel) {
      channels.push_back(channel);
      count.push_back(0);
    }
    slot.push_back(static_cast<std::uint32_t>(channels.size() - 1));
    ++count.back();
    background += raster.background(channel);
    in_group += raster.tiles().highest[channel];
    if (in_group > 255) {
      groups.push_back(i);
      in_group = raster.tiles().highest[channel];
    }
  }
  groups.push_back(static_cast<std::uint32_t>(samples.size()));
  reach = static_cast<std::int64_t>(std::ceil(radiusOf(samples) / raster.cellSize())) + 1;
}

/// A contiguous copy of a rectangle of the raster, one layer per channel: so the inner loop knows
/// nothing of tiles.
class Window {
 public:
  Window(const Tiles& tiles, const std::vector<std::uint16_t>& channels, std::int64_t side)
      : tiles_(tiles),
        channels_(channels),
        side_(side),
        cells_(channels.size() * static_cast<std::size_t>(side * side)) {}

  std::int64_t side() const { return side_; }

  void load(std::int64_t first_x, std::int64_t first_y) {
    for (std::size_t slot = 0; slot < channels_.size(); ++slot) {
      for (std::int64_t ty = first_y >> kTileBits; ty <= (first_y + side_ - 1) >> kTileBits; ++ty) {
        for (std::int64_t tx = first_x >> kTileBits; tx <= (first_x + side_ - 1) >> kTileBits;
             ++tx) {
          copyTile(slot, tx, ty, first_x, first_y);
        }
      }
    }
  }

  const std::uint8_t* cell(std::size_t slot, std::int64_t x, std::int64_t y) const {
    return cells_.data() + static_cast<std::int64_t>(slot) * side_ * side_ + y * side_ + x;
  }

 private:
  void copyTile(std::size_t slot, std::int64_t tx, std::int64_t ty, std::int64_t first_x,
                std::int64_t first_y) {
    const Tiles::Tile* tile = tiles_.find(channels_[slot], tx, ty);
    const std::int64_t x0 = std::max(first_x, tx * kTileSide),
                       x1 = std::min(first_x + side_, (tx + 1) * kTileSide);
    const std::int64_t y0 = std::max(first_y, ty * kTileSide),
                       y1 = std::min(first_y + side_, (ty + 1) * kTileSide);
    const auto length = static_cast<std::size_t>(x1 - x0);
    for (std::int64_t y = y0; y < y1; ++y) {
      std::uint8_t* to = const_cast<std::uint8_t*>(cell(slot, x0 - first_x, y - first_y));
      if (tile) {
        std::memcpy(to,
                    tile->cells.data() + (y - ty * kTileSide) * kTileSide + (x0 - tx * kTileSide),
                    length);
      } else {
        std::memset(to, tiles_.background[channels_[slot]], length);
      }
    }
  }

  const Tiles& tiles_;
  const std::vector<std::uint16_t>& channels_;
  std::int64_t side_;
  std::vector<std::uint8_t> cells_;
};

/// Where each sample reads in a window of a given side, for every heading, relative to the cell of
/// the query centre.
std::vector<std::int32_t> offsetTable(const PreparedSamples& prepared, const YawGrid& grid,
                                      double cell_m, std::int64_t window_side) {
  std::vector<std::int32_t> table;
  table.reserve(static_cast<std::size_t>(grid.count) * prepared.samples.size());
  for (int i = 0; i < grid.count; ++i) {
    const double cosine = std::cos(grid.yaw(i)), sine = std::sin(grid.yaw(i));
    for (const RasterSample& s : prepared.samples) {
      const CellOffset offset = cellOffset(s, cosine, sine, cell_m);
      table.push_back(static_cast<std::int32_t>(offset.y * window_side + offset.x));
    }
  }
  return table;
}

/// A cell of the pose space and its score. The order is total, so that the best K are the same
/// whoever finds them.
struct Candidate {
  std::int32_t score;
  std::int32_t yaw;
  std::int64_t x, y;

  bool operator<(const Candidate& b) const {
    return std::tie(b.score, y, x, yaw) < std::tie(score, b.y, b.x, b.yaw);
  }
};

/// The best K of all candidates that are offered. A threshold below which nothing can be among them
/// rises on the way.
class BestCandidates {
 public:
  explicit BestCandidates(std::size_t keep) : keep_(std::max<std::size_t>(1, keep)) {}

  std::int32_t threshold() const { return threshold_; }

  void offer(const Candidate& candidate) {
    if (candidate.score < threshold_) return;
    candidates_.push_back(candidate);
    if (candidates_.size() >= 2 * keep_) prune();
  }

  void merge(const BestCandidates& other) {
    for (const Candidate& candidate : other.candidates_) offer(candidate);
  }

  std::vector<Candidate> sorted() && {
    prune();
    std::sort(candidates_.begin(), candidates_.end());
    return std::move(candidates_);
  }

 private:
  void prune() {
    if (candidates_.size() <= keep_) return;
    const auto last = candidates_.begin() + static_cast<std::ptrdiff_t>(keep_ - 1);
    std::nth_element(candidates_.begin(), last, candidates_.end());
    threshold_ = last->score;
    candidates_.resize(keep_);
  }

  std::size_t keep_;
  std::int32_t threshold_ = 1;
  std::vector<Candidate> candidates_;
};

/// A tile of output cells with an upper bound of their scores.
struct OutputTile {
  std::int64_t tx, ty;
  std::int64_t bound;
  std::uint8_t bands;  ///< bit b: rows [8 b, 8 b + 8) are worth a look
};

bool touchesCircle(std::int64_t tx, std::int64_t ty, const PlacePrior::Circle& circle,
                   double cell_m) {
  const double side = cell_m * kTileSide, x0 = static_cast<double>(tx) * side,
               y0 = static_cast<double>(ty) * side;
  const double dx = circle.x - std::clamp(circle.x, x0, x0 + side),
               dy = circle.y - std::clamp(circle.y, y0, y0 + side);
  return std::hypot(dx, dy) <= circle.radius + cell_m;
}

/// Each channel contributes at most its number of samples times the largest rise over the
/// background in reach.
std::int64_t scoreBound(const Tiles& tiles, const PreparedSamples& prepared, std::int64_t tx,
                        std::int64_t ty, std::int64_t reach_tiles) {
  std::int64_t bound = 0;
  for (std::size_t slot = 0; slot < prepared.channels.size(); ++slot) {
    const std::uint16_t channel = prepared.channels[slot];
    int highest = tiles.background[channel];
    for (std::int64_t y = ty - reach_tiles; y <= ty + reach_tiles; ++y) {
      for (std::int64_t x = tx - reach_tiles; x <= tx + reach_tiles; ++x) {
        const Tiles::Tile* tile = tiles.find(channel, x, y);
        if (tile) highest = std::max<int>(highest, tile->highest);
      }
    }
    bound +=
        static_cast<std::int64_t>(prepared.count[slot]) * (highest - tiles.background[channel]);
  }
  return bound;
}

/// Where the raster has cells above the background, in parts of 8x8 cells of any channel of the
/// query.
class RaisedParts {
 public:
  RaisedParts(const Tiles& tiles, const std::vector<std::uint16_t>& channels) {
    for (const Tiles::Tile& tile : tiles.tiles) {
      if (tile.raised == 0 || !std::binary_search(channels.begin(), channels.end(), tile.channel))
        continue;
      raised_of_tile_[{tile.ty, tile.tx}] |= tile.raised;
    }
  }

  /// Tiles within `reach` tiles of one with raised cells, as (ty, tx), sorted.
  std::vector<std::pair<std::int64_t, std::int64_t>> tilesWithin(std::int64_t reach) const {
    std::vector<std::pair<std::int64_t, std::int64_t>> tiles;
    for (const auto& [place, raised] : raised_of_tile_) {
      for (std::int64_t y = place.first - reach; y <= place.first + reach; ++y) {
        for (std::int64_t x = place.second - reach; x <= place.second + reach; ++x)
          tiles.emplace_back(y, x);
      }
    }
    std::sort(tiles.begin(), tiles.end());
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
    return tiles;
  }

  /// Bands of 8 rows of a tile that are within `reach` cells of raised parts.
  std::uint8_t bandsNear(std::int64_t tx, std::int64_t ty, std::int64_t reach) const {
    const std::int64_t parts =
        std::min<std::int64_t>((reach + kPartSide - 1) / kPartSide, kParts * 1000);
    const std::int64_t tiles = (parts + kParts - 1) / kParts;
    std::uint8_t bands = 0;
    for (std::int64_t dy = -tiles; dy <= tiles && bands != 0xFF; ++dy) {
      for (std::int64_t dx = -tiles; dx <= tiles; ++dx) {
        const auto it = raised_of_tile_.find({ty + dy, tx + dx});
        if (it == raised_of_tile_.end()) continue;
        for (std::int64_t row = 0; row < kParts; ++row) {
          if (rowReaches(it->second, row, dx, parts))
            bands |= bandsAround(dy * kParts + row, parts);
        }
      }
    }
    return bands;
  }

 private:
  /// True if one of the raised parts of a row in the tile dx beside is near enough in x.
  static bool rowReaches(std::uint64_t raised, std::int64_t row, std::int64_t dx,
                         std::int64_t parts) {
    for (std::int64_t column = 0; column < kParts; ++column) {
      if (!(raised >> (row * kParts + column) & 1)) continue;
      const std::int64_t x = dx * kParts + column;
      if (x >= -parts && x < kParts + parts) return true;
    }
    return false;
  }

  static std::uint8_t bandsAround(std::int64_t row, std::int64_t parts) {
    std::uint8_t bands = 0;
    for (std::int64_t b = std::max<std::int64_t>(0, row - parts);
         b <= std::min<std::int64_t>(kParts - 1, row + parts); ++b) {
      bands = static_cast<std::uint8_t>(bands | 1u << b);
    }
    return bands;
  }

  std::map<std::pair<std::int64_t, std::int64_t>, std::uint64_t> raised_of_tile_;
};

/// The tiles where a query centre can score, the most promising first so that the threshold rises
/// early.
std::vector<OutputTile> outputTiles(const LikelihoodRaster& raster, const PreparedSamples& prepared,
                                    const RasterSearchOptions& options) {
  const Tiles& tiles = raster.tiles();
  const RaisedParts raised(tiles, prepared.channels);
  const std::int64_t reach_tiles = (prepared.reach + kTileSide - 1) / kTileSide;
  const double margin = options.margin_m / raster.cellSize();
  const std::int64_t reach = margin < static_cast<double>(prepared.reach)
                                 ? static_cast<std::int64_t>(std::ceil(std::max(0.0, margin)))
                                 : prepared.reach;
  std::vector<OutputTile> outputs;
  for (const auto& [ty, tx] : raised.tilesWithin((reach + kTileSide - 1) / kTileSide)) {
    const auto& near = options.centre_prior.near;
    if (near && !touchesCircle(tx, ty, *near, raster.cellSize())) continue;
    const std::uint8_t bands = raised.bandsNear(tx, ty, reach);
    if (bands == 0) continue;
    const std::int64_t bound = scoreBound(tiles, prepared, tx, ty, reach_tiles);
    if (bound > 0) outputs.push_back({tx, ty, bound, bands});
  }
  std::stable_sort(outputs.begin(), outputs.end(),
                   [](const OutputTile& a, const OutputTile& b) { return a.bound > b.bound; });
  return outputs;
}

int workerCount(int threads, std::size_t jobs) {
  const auto cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return static_cast<int>(
      std::min<std::size_t>(static_cast<std::size_t>(threads > 0 ? threads : cores), jobs));
}

/// Neighbouring rows of a tile.
struct RowRun {
  std::int64_t first;
  int count;
};

std::vector<RowRun> runsOf(std::uint8_t bands) {
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

/// The exhaustive search of one raster.
class Scan {
 public:
  Scan(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples,
       const RasterSearchOptions& options)
      : raster_(raster),
        options_(options),
        prepared_(raster, samples),
        grid_(yawGrid(yawStep(options.max_yaw_step_rad, raster.cellSize(), radiusOf(samples)),
                      options.centre_prior.heading)),
        window_side_(kBlockSide + 2 * prepared_.reach),
        offsets_(offsetTable(prepared_, grid_, raster.cellSize(), window_side_)) {}

  const YawGrid& grid() const { return grid_; }

  /// The best keep_cells candidates, best first.
  std::vector<Candidate> run() {
    const std::vector<OutputTile> outputs = outputTiles(raster_, prepared_, options_);
    const int workers = workerCount(options_.threads, outputs.size());
    std::vector<BestCandidates> best(static_cast<std::size_t>(workers),
                                     BestCandidates(options_.keep_cells));
    std::atomic<std::size_t> next{0};
    parallelFor(best.size(), workers, [&](std::size_t worker) {
      Window window(raster_.tiles(), prepared_.channels, window_side_);
      for (std::size_t i = next++; i < outputs.size(); i = next++)
        scanTile(outputs[i], window, best[worker]);
    });
    BestCandidates all(options_.keep_cells);
    for (const BestCandidates& part : best) all.merge(part);
    return std::move(all).sorted();
  }

 private:
  /// Only raises what all workers may skip: a cell below the K best of one worker is not among the
  /// K best of all.
  void publish(std::int32_t threshold) {
    std::int32_t known = threshold_.load(std::memory_order_relaxed);
    while (known < threshold &&
           !threshold_.compare_exchange_weak(known, threshold, std::memory_order_relaxed)) {
    }
  }

  void scanTile(const OutputTile& output, Window& window, BestCandidates& best) {
    if (output.bound < std::max(best.threshold(), threshold_.load(std::memory_order_relaxed)))
      return;
    const std::int64_t x0 = output.tx * kTileSide, y0 = output.ty * kTileSide;
    window.load(x0 - prepared_.reach, y0 - prepared_.reach);
    const std::size_t n = prepared_.samples.size();
    std::vector<const std::uint8_t*> base(n), pointers(n);
    for (std::size_t k = 0; k < n; ++k)
      base[k] = window.cell(prepared_.slot[k], prepared_.reach, prepared_.reach);
    std::vector<raster::BlockHit> hits(static_cast<std::size_t>(kBlockSide * kBlockSide));
    const std::vector<RowRun> runs = runsOf(output.bands);
    const raster::ScanFunction scan_block = raster::scanVariants().variant[0].function;
    for (int yaw = 0; yaw < grid_.count; ++yaw) {
      const std::int32_t* offset = offsets_.data() + static_cast<std::size_t>(yaw) * n;
      for (const auto& [row, rows] : runs) {
        for (std::size_t k = 0; k < n; ++k) pointers[k] = base[k] + offset[k] + row * window.side();
        const std::int64_t threshold =
            std::max(best.threshold(), threshold_.load(std::memory_order_relaxed)) +
            prepared_.background;
        const raster::BlockScan block{pointers.data(),
                                      prepared_.groups.data(),
                                      prepared_.groups.size() - 1,
                                      window.side(),
                                      rows,
                                      static_cast<std::uint32_t>(threshold)};
        const std::size_t count = scan_block(block, hits.data());
        for (std::size_t i = 0; i < count; ++i) {
          const Candidate candidate{static_cast<std::int32_t>(hits[i].sum - prepared_.background),
                                    yaw, x0 + hits[i].column, y0 + row + hits[i].row};
          if (isAllowed(candidate)) best.offer(candidate);
        }
      }
    }
    publish(best.threshold());
  }

  bool isAllowed(const Candidate& c) const {
    const auto& near = options_.centre_prior.near;
    if (!near) return true;
    const double cell = raster_.cellSize();
    const double x = (static_cast<double>(c.x) + 0.5) * cell,
                 y = (static_cast<double>(c.y) + 0.5) * cell;
    return std::hypot(x - near->x, y - near->y) <=
           near->radius + 0.71 * cell;  // the cell may touch the circle
  }

  const LikelihoodRaster& raster_;
  const RasterSearchOptions& options_;
  PreparedSamples prepared_;
  YawGrid grid_;
  std::int64_t window_side_;
  std::vector<std::int32_t> offsets_;
  std::atomic<std::int32_t> threshold_{1};
};

/// Looks at the fine cells and headings behind each coarse candidate.
class Refinement {
 public:
  Refinement(const FineLevel& fine, int cell_ratio, const YawGrid& coarse_grid)
      : ratio_(cell_ratio),
        prepared_(fine.raster, fine.samples),
        tiles_(fine.raster.tiles()),
        yaws_per_coarse_(yawsPerCoarse(fine, coarse_grid)),
        grid_(fineGrid(coarse_grid)),
        window_side_(kTileSide * ratio_ + 2 * prepared_.reach),
        offsets_(offsetTable(prepared_, grid_, fine.raster.cellSize(), window_side_)) {}

  const YawGrid& grid() const { return grid_; }

  /// One fine candidate of positive score per coarse one at most, best first.
  std::vector<Candidate> run(std::vector<Candidate> coarse, int threads) const {
    std::sort(coarse.begin(), coarse.end(), [](const Candidate& a, const Candidate& b) {
      return std::make_tuple(a.y >> kTileBits, a.x >> kTileBits, a) <
             std::make_tuple(b.y >> kTileBits, b.x >> kTileBits, b);
    });
    std::vector<std::size_t> first_of_tile;
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      if (i == 0 || !sameTile(coarse[i - 1], coarse[i])) first_of_tile.push_back(i);
    }
    first_of_tile.push_back(coarse.size());
    const std::size_t count = first_of_tile.size() - 1;
    const int workers = workerCount(threads, count);
    std::atomic<std::size_t> next{0};
    parallelFor(static_cast<std::size_t>(workers), workers, [&](std::size_t) {
      Window window(tiles_, prepared_.channels, window_side_);
      for (std::size_t t = next++; t < count; t = next++) {
        refineTile(coarse, first_of_tile[t], first_of_tile[t + 1], window);
      }
    });
    coarse.erase(std::remove_if(coarse.begin(), coarse.end(),
                                [](const Candidate& c) { return c.score <= 0; }),
                 coarse.end());
    std::sort(coarse.begin(), coarse.end());
    return coarse;
  }

 private:
  static int yawsPerCoarse(const FineLevel& fine, const YawGrid& coarse_grid) {
    const double step =
        yawStep(fine.max_yaw_step_rad, fine.raster.cellSize(), radiusOf(fine.samples));
    return std::max(1, static_cast<int>(std::ceil(coarse_grid.step / step - 1e-9)));
  }

  YawGrid fineGrid(const YawGrid& coarse) const {
    const double step = coarse.step / yaws_per_coarse_;
    return {coarse.first + (0.5 - 0.5 * yaws_per_coarse_) * step, step,
            coarse.count * yaws_per_coarse_};
  }

  static bool sameTile(const Candidate& a, const Candidate& b) {
    return a.x >> kTileBits == b.x >> kTileBits && a.y >> kTileBits == b.y >> kTileBits;
  }

  void refineTile(std::vector<Candidate>& candidates, std::size_t begin, std::size_t end,
                  Window& window) const {
    const std::int64_t x0 = (candidates[begin].x >> kTileBits) * kTileSide * ratio_;
    const std::int64_t y0 = (candidates[begin].y >> kTileBits) * kTileSide * ratio_;
    window.load(x0 - prepared_.reach, y0 - prepared_.reach);
    std::vector<std::int32_t> sums(static_cast<std::size_t>(ratio_ * ratio_));
    for (std::size_t i = begin; i < end; ++i) {
      const Candidate coarse = candidates[i];
      Candidate best{-1, 0, 0, 0};
      for (int t = 0; t < yaws_per_coarse_; ++t) {
        const int yaw = coarse.yaw * yaws_per_coarse_ + t;
        const std::int64_t x = coarse.x * ratio_, y = coarse.y * ratio_;
        sumCells(window, x - x0, y - y0, yaw, sums);
        for (std::size_t k = 0; k < sums.size(); ++k) {
          const auto cell = static_cast<std::int64_t>(k);
          best = std::min(best, Candidate{sums[k], yaw, x + cell % ratio_, y + cell / ratio_});
        }
      }
      candidates[i] = best;
    }
  }

  void sumCells(const Window& window, std::int64_t x, std::int64_t y, int yaw,
                std::vector<std::int32_t>& sums) const {
    std::fill(sums.begin(), sums.end(), static_cast<std::int32_t>(-prepared_.background));
    const std::size_t n = prepared_.samples.size();
    const std::int32_t* offset = offsets_.data() + static_cast<std::size_t>(yaw) * n;
    const std::int64_t side = window.side();
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint8_t* cell =
          window.cell(prepared_.slot[k], x + prepared_.reach, y + prepared_.reach) + offset[k];
      std::int32_t* sum = sums.data();
      for (int row = 0; row < ratio_; ++row, cell += side) {
        for (int column = 0; column < ratio_; ++column) *sum++ += cell[column];
      }
    }
  }

  int ratio_;
  PreparedSamples prepared_;
  const Tiles& tiles_;
  int yaws_per_coarse_;
  YawGrid grid_;
  std::int64_t window_side_;
  std::vector<std::int32_t> offsets_;
};

/// Greedy non-maximum suppression within 1.6 cells and 1.6 yaw steps; candidates are sorted.
std::vector<PlacePose> distinctPoses(const std::vector<Candidate>& candidates, const YawGrid& grid,
                                     double cell_m, std::size_t keep) {
  constexpr double kCells = 1.6, kYawSteps = 1.6;
  constexpr std::int64_t kBinCells = 2;  // a suppressed neighbour is in one of the 3x3 bins around
  std::vector<PlacePose> poses;
  std::vector<Candidate> kept;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> kept_in_bin;
  const auto bin = [](std::int64_t x, std::int64_t y) { return y * 0x100000001ll + x; };
  const auto floorBin = [](std::int64_t cell) {
    return cell >= 0 ? cell / kBinCells : -((-cell + kBinCells - 1) / kBinCells);
  };
  const auto suppresses = [&](const Candidate& a, const Candidate& b) {
    const double d = std::hypot(static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y));
    return d < kCells &&
           std::abs(angleDifference(grid.yaw(a.yaw), grid.yaw(b.yaw))) < kYawSteps * grid.step;
  };
  for (const Candidate& c : candidates) {
    if (poses.size() >= keep) break;
    const std::int64_t bx = floorBin(c.x), by = floorBin(c.y);
    bool suppressed = false;
    for (std::int64_t y = by - 1; y <= by + 1 && !suppressed; ++y) {
      for (std::int64_t x = bx - 1; x <= bx + 1 && !suppressed; ++x) {
        const auto it = kept_in_bin.find(bin(x, y));
        if (it == kept_in_bin.end()) continue;
        suppressed = std::any_of(it->second.begin(), it->second.end(),
                                 [&](std::size_t k) { return suppresses(kept[k], c); });
      }
    }
    if (suppressed) continue;
    kept_in_bin[bin(bx, by)].push_back(kept.size());
    kept.push_back(c);
    poses.push_back({(static_cast<double>(c.x) + 0.5) * cell_m,
                     (static_cast<double>(c.y) + 0.5) * cell_m, angleDifference(grid.yaw(c.yaw), 0),
                     static_cast<double>(c.score)});
  }
  return poses;
}

}  // namespace

std::vector<PlacePose> searchRaster(const LikelihoodRaster& raster,
                                    const std::vector<RasterSample>& samples,
                                    const RasterSearchOptions& options) {
  check(raster, samples);
  if (samples.empty()) return {};
  Scan scan(raster, samples, options);
  return distinctPoses(scan.run(), scan.grid(), raster.cellSize(), options.keep_poses);
}

std::vector<PlacePose> searchRaster(const LikelihoodRaster& coarse,
                                    const std::vector<RasterSample>& samples, const FineLevel& fine,
                                    const RasterSearchOptions& options) {
  check(coarse, samples);
  check(fine.raster, fine.samples);
  const double ratio = coarse.cellSize() / fine.raster.cellSize();
  if (std::abs(ratio - std::round(ratio)) > 1e-6 || ratio < 0.5) {
    throw UsageError("raster search: coarse cells of " + std::to_string(coarse.cellSize()) +
                     " m are no multiple of fine cells of " +
                     std::to_string(fine.raster.cellSize()) + " m");
  }
  if (samples.empty() || fine.samples.empty()) return {};
  Scan scan(coarse, samples, options);
  const Refinement refinement(fine, static_cast<int>(std::lround(ratio)), scan.grid());
  return distinctPoses(refinement.run(scan.run(), options.threads), refinement.grid(),
                       fine.raster.cellSize(), options.keep_poses);
}

int rasterScore(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples,
                const PlacePose& pose) {
  check(raster, samples);
  const double cell = raster.cellSize(), cosine = std::cos(pose.yaw), sine = std::sin(pose.yaw);
  const auto cellOf = [](double v) {
    return static_cast<std::int32_t>(std::floor(v + kRoundingSlack));
  };
  int score = 0;
  for (const RasterSample& s : samples) {
    const std::int32_t cx = cellOf(pose.x / cell + (cosine * s.x - sine * s.y) / cell);
    const std::int32_t cy = cellOf(pose.y / cell + (sine * s.x + cosine * s.y) / cell);
    score += raster.at(s.channel, cx, cy) - raster.background(s.channel);
  }
  return score;
}

}  // namespace xview
