// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/plan_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "xview/types/parallel.h"

namespace xview {
namespace {

constexpr int kSide = PlanField::kTileCells;
constexpr int kCells = kSide * kSide;
constexpr float kReach_m = 9.f;    ///< beyond it every distance is in the last class
constexpr float kSeenNear_m = 1.f; ///< a cell this near to a seen one counts as seen
constexpr int kNearBins = 5;       ///< classes below 2 m say something even where the map was not seen

using TileKey = std::pair<std::int32_t, std::int32_t>;  ///< (y, x)

std::int32_t cellOf(float p, float side) { return static_cast<std::int32_t>(std::floor(p / side)); }

/// Samples of one channel grouped by tile.
std::map<TileKey, std::vector<PlanSample>> byTile(const std::vector<PlanSample>& samples, float side) {
  std::map<TileKey, std::vector<PlanSample>> groups;
  for (const PlanSample& s : samples) groups[{cellOf(s.y, side) >> 6, cellOf(s.x, side) >> 6}].push_back(s);
  return groups;
}

/// Nearest-sample distances on a window of cells around a tile by propagating the nearest sample in two sweeps.
class DistanceWindow {
 public:
  DistanceWindow(int margin, float side) : margin_(margin), width_(kSide + 2 * margin), side_(side),
        nearest_(static_cast<std::size_t>(width_) * width_), squared_(nearest_.size()) {}

  /// Coordinates of samples are relative to the first cell of the tile, in metres.
  void compute(const std::vector<PlanSample>& samples) {
    samples_ = &samples;
    std::fill(nearest_.begin(), nearest_.end(), -1);
    std::fill(squared_.begin(), squared_.end(), std::numeric_limits<float>::max());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const int x = cellOf(samples[i].x, side_) + margin_, y = cellOf(samples[i].y, side_) + margin_;
      if (x < 0 || y < 0 || x >= width_ || y >= width_) continue;
      relax(x, y, static_cast<std::int32_t>(i));
    }
    for (int y = 0; y < width_; ++y) {
      for (int x = 0; x < width_; ++x) {
        take(x, y, x - 1, y);
        for (int dx = -1; dx <= 1; ++dx) take(x, y, x + dx, y - 1);
      }
      for (int x = width_ - 2; x >= 0; --x) take(x, y, x + 1, y);
    }
    for (int y = width_ - 1; y >= 0; --y) {
      for (int x = width_ - 1; x >= 0; --x) {
        take(x, y, x + 1, y);
        for (int dx = -1; dx <= 1; ++dx) take(x, y, x + dx, y + 1);
      }
      for (int x = 1; x < width_; ++x) take(x, y, x - 1, y);
    }
  }
  /// Squared distance at a cell of the tile [m^2].
  float squared(int x, int y) const { return squared_[index(x + margin_, y + margin_)]; }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }
  void relax(int x, int y, std::int32_t sample) {
    const float dx = (static_cast<float>(x - margin_) + 0.5f) * side_ - (*samples_)[sample].x;
    const float dy = (static_cast<float>(y - margin_) + 0.5f) * side_ - (*samples_)[sample].y;
    const float d = dx * dx + dy * dy;
    const std::size_t i = index(x, y);
    if (d < squared_[i]) {
      squared_[i] = d;
      nearest_[i] = sample;
    }
  }
  void take(int x, int y, int from_x, int from_y) {
    if (from_x < 0 || from_y < 0 || from_x >= width_ || from_y >= width_) return;
    const std::int32_t sample = nearest_[index(from_x, from_y)];
    if (sample >= 0 && sample != nearest_[index(x, y)]) relax(x, y, sample);
  }

  int margin_, width_;
  float side_;
  const std::vector<PlanSample>* samples_ = nullptr;
  std::vector<std::int32_t> nearest_;
  std::vector<float> squared_;
};

std::uint8_t binOfSquared(float squared) {
  int bin = 0;
  while (bin < kDistanceBins - 1 && squared >= kBinLimits_m[bin] * kBinLimits_m[bin]) ++bin;
  return static_cast<std::uint8_t>(bin);
}

/// Cells of each tile that were seen, grown by kSeenNear_m; the key set is the set of tiles of the field.
std::map<TileKey, std::vector<std::uint8_t>> seenTiles(const PlanView& map) {
  std::map<TileKey, std::vector<std::uint8_t>> seen;
  const int reach = static_cast<int>(kSeenNear_m / map.cell_m);
  TileKey last{std::numeric_limits<std::int32_t>::max(), 0};
  std::vector<std::uint8_t>* mask = nullptr;
  for (const GroundCell& cell : map.known) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const TileKey key{(cell.y + dy) >> 6, (cell.x + dx) >> 6};
        if (!mask || key != last) {
          mask = &seen[key];
          mask->resize(kCells, 0);
          last = key;
        }
        (*mask)[PlanField::cellInTile(cell.x + dx, cell.y + dy)] = 1;
      }
    }
  }
  return seen;
}

}  // namespace

PlanField::PlanField(const PlanView& map, int threads)
    : cell_m_(map.cell_m), origin_x_(map.origin_x), origin_y_(map.origin_y) {
  const auto side = static_cast<float>(cell_m_);
  const auto seen = seenTiles(map);
  if (seen.empty()) return;
  std::vector<std::map<TileKey, std::vector<PlanSample>>> groups(kChannels);
  parallelFor(kChannels, threads, [&](std::size_t c) { groups[c] = byTile(map.samples[c], side); });

  std::vector<const std::vector<std::uint8_t>*> masks;
  std::int32_t min_x = std::numeric_limits<std::int32_t>::max(), max_x = std::numeric_limits<std::int32_t>::min();
  for (const auto& [key, mask] : seen) {
    Tile tile;
    tile.y = key.first;
    tile.x = key.second;
    min_x = std::min(min_x, tile.x);
    max_x = std::max(max_x, tile.x);
    tiles_.push_back(std::move(tile));
    masks.push_back(&mask);
  }
  block_x_ = min_x >> kBlockBits;
  block_y_ = tiles_.front().y >> kBlockBits;
  blocks_wide_ = (max_x >> kBlockBits) - block_x_ + 1;
  blocks_high_ = (tiles_.back().y >> kBlockBits) - block_y_ + 1;
  blocks_.resize(static_cast<std::size_t>(blocks_wide_) * blocks_high_);
  constexpr std::int32_t in_block = (1 << kBlockBits) - 1;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    auto& block = blocks_[static_cast<std::size_t>((tiles_[i].y >> kBlockBits) - block_y_) * blocks_wide_ +
                          ((tiles_[i].x >> kBlockBits) - block_x_)];
    if (block.empty()) block.assign(std::size_t{1} << (2 * kBlockBits), -1);
    block[(static_cast<std::size_t>(tiles_[i].y & in_block) << kBlockBits) + (tiles_[i].x & in_block)] =
        static_cast<std::int32_t>(i);
  }

  const int margin = static_cast<int>(std::ceil(kReach_m / side));
  const int tiles_around = (margin + kSide - 1) / kSide;
  std::vector<std::vector<std::vector<std::uint8_t>>> planes(tiles_.size());
  std::vector<std::array<int, kChannels>> plane_of(tiles_.size());
  parallelFor(tiles_.size(), threads, [&](std::size_t t) {
    DistanceWindow window(margin, side);
    const Tile& tile = tiles_[t];
    std::vector<std::uint8_t> far(kCells);
    for (int i = 0; i < kCells; ++i) {
      far[i] = static_cast<std::uint8_t>((*masks[t])[i] ? kDistanceBins - 1 : kUnknownBin);
    }
    planes[t].push_back(far);
    const float x0 = static_cast<float>(tile.x) * kSide * side, y0 = static_cast<float>(tile.y) * kSide * side;
    std::vector<PlanSample> around;
    for (std::size_t c = 0; c < kChannels; ++c) {
      around.clear();
      for (int dy = -tiles_around; dy <= tiles_around; ++dy) {
        for (int dx = -tiles_around; dx <= tiles_around; ++dx) {
          const auto it = groups[c].find({tile.y + dy, tile.x + dx});
          if (it == groups[c].end()) continue;
          for (const PlanSample& s : it->second) around.push_back({s.x - x0, s.y - y0, s.z});
        }
      }
      plane_of[t][c] = 0;
      if (around.empty()) continue;
      window.compute(around);
      std::vector<std::uint8_t> plane(kCells);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const std::uint8_t bin = binOfSquared(window.squared(x, y));
          const bool unknown = bin >= kNearBins && !(*masks[t])[y * kSide + x];
          plane[y * kSide + x] = unknown ? static_cast<std::uint8_t>(kUnknownBin) : bin;
        }
      }
      plane_of[t][c] = static_cast<int>(planes[t].size());
      planes[t].push_back(std::move(plane));
    }
  });
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    const std::size_t first = planes_.size();
    for (auto& plane : planes[t]) planes_.push_back(std::move(plane));
    for (std::size_t c = 0; c < kChannels; ++c) tiles_[t].bins[c] = planes_[first + plane_of[t][c]].data();
    tiles_[t].ground.assign(kCells, std::numeric_limits<float>::quiet_NaN());
  }
  for (const GroundCell& cell : map.known) {
    if (!cell.measured) continue;
    const Tile* tile = tileOfCell(cell.x, cell.y);
    const_cast<Tile*>(tile)->ground[cellInTile(cell.x, cell.y)] = cell.z;
  }
}

PlanField::~PlanField() = default;
PlanField::PlanField(PlanField&&) noexcept = default;
PlanField& PlanField::operator=(PlanField&&) noexcept = default;

std::size_t PlanField::bytes() const {
  return planes_.size() * kCells + tiles_.size() * (sizeof(Tile) + kCells * sizeof(float));
}

}  // namespace xview
