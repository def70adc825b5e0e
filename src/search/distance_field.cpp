// SPDX-License-Identifier: BSD-3-Clause
#include "search/distance_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "base/cells.h"
#include "base/parallel.h"

namespace xview::search {
namespace {

// Compiled with -O3 -ffp-contract=off: vectors of any width, but the same roundings with all of
// them.
#define XVIEW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

constexpr int kSide = DistanceField::kTileCells;
constexpr int kHalfSide = kSide / 2;
constexpr int kTileBits = 6;
static_assert(kSide == 1 << kTileBits);
constexpr float kReach_m = kBinLimits_m.back();  ///< beyond it every distance is in the last class
constexpr float kSeenNear_m = 1.f;               ///< a cell this near to a seen one counts as seen
constexpr float kFar = 1e9f;                     ///< squared distance where there is no sample
constexpr int kNearBins = 5;  ///< classes below 2 m say something even where the map was not seen
static_assert(kBinLimits_m[kNearBins - 1] == 2.f, "classes below 2 m");
static_assert(kReach_m + kSeenNear_m <= DistanceField::kRim_m, "what a tile is made of");

/// Cells of a tile that were seen: a bit each, row by row.
using Mask = std::array<std::uint64_t, kSide>;

bool isEmpty(const Mask& mask) {
  return std::all_of(mask.begin(), mask.end(), [](std::uint64_t row) { return row == 0; });
}

/// Of cells of twice the size: those with a seen cell.
Mask halved(const Mask& mask) {
  Mask half{};
  for (int y = 0; y < kHalfSide; ++y) {
    const std::uint64_t row = mask[2 * y] | mask[2 * y + 1];
    for (int x = 0; x < kHalfSide; ++x) half[y] |= std::uint64_t{(row >> 2 * x & 3) != 0} << x;
  }
  return half;
}

/// The rows of a tile and of the eight around it, row by row; null where there is none.
using MasksAround = std::array<const Mask*, 9>;

/// The cells within `reach` rows and columns of a seen one, reach < 64.
Mask grown(const MasksAround& around, int reach) {
  Mask result{};
  for (int y = 0; y < kSide; ++y) {
    std::array<std::uint64_t, 3> row{};  // to the left, here, to the right
    for (int from = y - reach; from <= y + reach; ++from) {
      const int band = from < 0 ? 0 : from < kSide ? 3 : 6;
      for (int i = 0; i < 3; ++i) {
        if (const Mask* mask = around[band + i]) row[i] |= (*mask)[from & (kSide - 1)];
      }
    }
    result[y] = row[1];
    for (int step = 1; step <= reach; ++step) {
      result[y] |= row[1] << step | row[0] >> (kSide - step);
      result[y] |= row[1] >> step | row[2] << (kSide - step);
    }
  }
  return result;
}

constexpr int kBlock = 16;  ///< columns that are looked at together

/// Lowers the distances of the cells of a tile up to `reach` rows and columns away to those to one
/// site, and of some more columns.
XVIEW_CLONES void tryOneSite(float site_x, float site_y, float reach, int side, float* squared) {
  const int first_row = std::max(0, static_cast<int>(site_y - reach) - 1),
            last_row = std::min(side, static_cast<int>(site_y + reach) + 1),
            first_column = std::max(0, static_cast<int>(site_x - reach) - 1) & ~(kBlock - 1),
            last_column = std::min(side, static_cast<int>(site_x + reach) + 1);
  for (int column = first_column; column < last_column; column += kBlock) {
    float across[kBlock];
    for (int x = 0; x < kBlock; ++x) {
      const float dx = static_cast<float>(column + x) + 0.5f - site_x;
      across[x] = dx * dx;
    }
    for (int y = first_row; y < last_row; ++y) {
      const float dy = static_cast<float>(y) + 0.5f - site_y, dy_squared = dy * dy;
      float* row = squared + y * side + column;
      for (int x = 0; x < kBlock; ++x) {
        const float d = across[x] + dy_squared;
        row[x] = d < row[x] ? d : row[x];
      }
    }
  }
}

XVIEW_CLONES void addReached(const float* __restrict squared, float limit, int cells,
                             std::uint8_t* __restrict counts) {
  for (int i = 0; i < cells; ++i) {
    counts[i] = static_cast<std::uint8_t>(counts[i] + (squared[i] >= limit));
  }
}

/// Limits of the classes in cells, squared.
std::vector<float> squaredLimits(double cell_m) {
  std::vector<float> limits;
  for (const float limit : kBinLimits_m) {
    limits.push_back(static_cast<float>(std::pow(limit / cell_m, 2)));
  }
  return limits;
}

/// The planes of one tile, and which of them each channel has. The first is that of all channels
/// without a sample in reach.
struct TilePlanes {
  std::vector<std::uint8_t> planes;
  std::array<std::size_t, kBevChannels> plane_of{};
};

/// `sites`: in cells from the first one of the tile, by channel.
template <class Sites>
TilePlanes makePlanes(const Sites& sites, const Mask& mask, int side, double cell_m) {
  TilePlanes result;
  const auto reach = static_cast<float>(kReach_m / cell_m);
  const auto limits = squaredLimits(cell_m);
  const auto cells = static_cast<std::size_t>(side * side);
  const auto present = std::count_if(sites.begin(), sites.end(),
                                     [](const auto& channel) { return !channel.empty(); });
  result.planes.reserve(static_cast<std::size_t>(present + 1) * cells);
  std::array<float, kSide * kSide> squared;  // above `reach` only known to be above it
  const auto append = [&](const typename Sites::value_type& of_channel) {
    std::fill_n(squared.begin(), cells, kFar);
    for (const auto& site : of_channel) tryOneSite(site.x, site.y, reach, side, squared.data());
    result.planes.resize(result.planes.size() + cells);
    std::uint8_t* plane = result.planes.data() + result.planes.size() - cells;
    for (const float limit : limits) addReached(squared.data(), limit, side * side, plane);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        std::uint8_t& bin = plane[y * side + x];
        if (bin >= kNearBins && !(mask[y] >> x & 1)) bin = static_cast<std::uint8_t>(kUnknownBin);
      }
    }
  };
  append({});
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (sites[c].empty()) continue;
    result.plane_of[c] = result.planes.size() / cells;
    append(sites[c]);
  }
  return result;
}

}  // namespace

/// A sample, in cells.
struct DistanceField::Site {
  float x, y;
};

/// Of a stored view: read at once.
struct DistanceField::Column {
  PlaneCell at;
  std::once_flag once;
};

struct DistanceField::Place {
  PlaneCell at;
  Column* column = nullptr;  ///< null if nothing is left to be read
  Mask seen{};
  Sites sites;
  std::vector<GroundCell> known;

  std::once_flag once;
  std::atomic<bool> is_made{false};
  Tile tile;
  std::vector<std::uint8_t> planes;  ///< what tile.bins points into; empty if there is no tile
};

DistanceField::DistanceField(const BevGrid& map)
    : cell_m_(map.cell_m), origin_x_(map.origin_x), origin_y_(map.origin_y) {
  distribute(map, [this](const PlaneCell& tile) { return &placeOf(tile); });
  for (std::size_t i = 0, read = all_.size(); i < read; ++i) {
    if (isEmpty(all_[i]->seen)) continue;
    for (int n = 0; n < 9; ++n)
      placeOf({all_[i]->at.x + n % 3 - 1, all_[i]->at.y + n / 3 - 1});  // what was seen is grown
  }
  for (const auto& place : all_) {
    if (!isEmpty(seenIn(place->at))) tiles_.push_back(place->at);
  }
}

DistanceField::DistanceField(const BevGrid& grid, std::shared_ptr<const StoredView> stored,
                             const MapOverview& tiles)
    : cell_m_(grid.cell_m),
      origin_x_(grid.origin_x),
      origin_y_(grid.origin_y),
      stored_(std::move(stored)) {
  const auto across = static_cast<int>(std::lround(StoredView::kColumn_m / (kSide * cell_m_)));
  for (const PlaneCell& at : stored_->columns()) {
    columns_.push_back(std::make_unique<Column>());
    columns_.back()->at = at;
    for (int y = 0; y < across; ++y) {
      for (int x = 0; x < across; ++x)
        placeOf({at.x * across + x, at.y * across + y}).column = columns_.back().get();
    }
  }
  for (const MapOverview::Tile& tile : tiles.tiles) {
    placeOf(tile.at);
    tiles_.push_back(tile.at);
  }
}

bool DistanceField::fitsColumns(double cell_m) {
  const double across = StoredView::kColumn_m / (kSide * cell_m);
  return across >= 1 && across == std::round(across);
}

DistanceField::~DistanceField() = default;
DistanceField::DistanceField(DistanceField&&) noexcept = default;

DistanceField::Place& DistanceField::placeOf(const PlaneCell& tile) {
  const std::size_t number = places_.numberOf(tile, [&] { return PlaceNumber{tile}; });
  if (number == all_.size()) {
    all_.push_back(std::make_unique<Place>());
    all_.back()->at = tile;
  }
  return *all_[number];
}

template <class PlaceFor>
void DistanceField::distribute(const BevGrid& part, const PlaceFor& placeFor) const {
  PlaneCell last{std::numeric_limits<std::int32_t>::max(), 0};
  Place* place = nullptr;
  const auto find = [&](const PlaneCell& tile) {
    if (!(tile == last)) place = placeFor(last = tile);
    return place;
  };
  for (const GroundCell& cell : part.known) {
    if (!find({cell.x >> kTileBits, cell.y >> kTileBits})) continue;
    place->known.push_back(cell);
    place->seen[cell.y & (kSide - 1)] |= std::uint64_t{1} << (cell.x & (kSide - 1));
  }
  const auto tileOf = [](float cell) {
    return static_cast<std::int32_t>(std::floor(cell / kSide));
  };
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (const BevSample& s : part.samples[c]) {
      const auto x = static_cast<float>(s.x / cell_m_), y = static_cast<float>(s.y / cell_m_);
      if (find({tileOf(x), tileOf(y)})) place->sites[c].push_back({x, y});
    }
  }
}

DistanceField::Place* DistanceField::findRead(const PlaneCell& tile) const {
  Place* place = find(tile);
  if (!place || !place->column) return place;
  std::call_once(place->column->once, [&] {
    distribute(*stored_->partOf(place->column->at), [&](const PlaneCell& at) -> Place* {
      Place* of_column = this->find(at);
      return of_column && of_column->column == place->column ? of_column : nullptr;
    });
  });
  return place;
}

void DistanceField::makeAll(int threads) const {
  parallelFor(all_.size(), threads, [&](std::size_t i) { tile(i); });
}

const DistanceField::Tile* DistanceField::tile(std::size_t number) const {
  Place& place = *all_[number];
  if (!place.is_made.load(std::memory_order_acquire))
    std::call_once(place.once, [&] { make(place); });
  return place.planes.empty() ? nullptr : &place.tile;
}

void DistanceField::make(Place& place) const {
  const Mask seen = seenIn(place.at);
  if (!isEmpty(seen)) {
    TilePlanes made = makePlanes(sitesAround(place.at), seen, kSide, cell_m_);
    Tile& tile = place.tile;
    tile.x = place.at.x;
    tile.y = place.at.y;
    for (std::size_t c = 0; c < kBevChannels; ++c)
      tile.bins[c] = made.planes.data() + made.plane_of[c] * kSide * kSide;
    tile.ground.assign(kSide * kSide, std::numeric_limits<float>::quiet_NaN());
    double sum = 0;
    for (const GroundCell& cell : place.known) {
      sum += double{cell.z};
      if (cell.measured) tile.ground[cellInTile(cell.x, cell.y)] = cell.z;
    }
    if (!place.known.empty())
      tile.level = static_cast<float>(sum / static_cast<double>(place.known.size()));
    place.planes = std::move(made.planes);
  }
  place.is_made.store(true, std::memory_order_release);
}

/// The cells of a tile that were seen, grown by kSeenNear_m.
Mask DistanceField::seenIn(const PlaneCell& tile) const {
  MasksAround around{};
  for (int i = 0; i < 9; ++i) {
    const Place* place = findRead({tile.x + i % 3 - 1, tile.y + i / 3 - 1});
    around[i] = place ? &place->seen : nullptr;
  }
  return grown(around, std::min(static_cast<int>(kSeenNear_m / cell_m_), kSide - 1));
}

/// Those within reach of a tile, in cells from its first one.
DistanceField::Sites DistanceField::sitesAround(const PlaneCell& tile) const {
  Sites result;
  const auto reach = static_cast<float>(kReach_m / cell_m_);
  const int tiles_around = static_cast<int>(reach) / kSide + 1;
  const float x0 = static_cast<float>(tile.x) * kSide, y0 = static_cast<float>(tile.y) * kSide;
  const auto inReach = [&](float p) { return p >= -reach && p <= kSide + reach; };
  for (int dy = -tiles_around; dy <= tiles_around; ++dy) {
    for (int dx = -tiles_around; dx <= tiles_around; ++dx) {
      const Place* place = findRead({tile.x + dx, tile.y + dy});
      if (!place) continue;
      for (std::size_t c = 0; c < kBevChannels; ++c) {
        for (const Site& s : place->sites[c]) {
          if (inReach(s.x - x0) && inReach(s.y - y0)) result[c].push_back({s.x - x0, s.y - y0});
        }
      }
    }
  }
  return result;
}

namespace {

/// Sites of a tile in cells of twice the size: one per cell, the mean of those in it.
template <class Sites>
Sites halved(const Sites& sites, float reach) {
  const int rim = static_cast<int>(reach / 2) + 1, side = kHalfSide + 2 * rim;
  std::vector<std::int32_t> site_of(static_cast<std::size_t>(side * side));
  const auto cellOf = [&](float at) { return std::clamp(floorToInt(at) + rim, 0, side - 1); };
  Sites result;
  std::vector<float> counts;
  for (std::size_t c = 0; c < sites.size(); ++c) {
    if (sites[c].empty()) continue;
    std::fill(site_of.begin(), site_of.end(), -1);
    counts.clear();
    for (const auto& site : sites[c]) {
      const float x = site.x / 2, y = site.y / 2;
      std::int32_t& number = site_of[static_cast<std::size_t>(cellOf(y) * side + cellOf(x))];
      if (number < 0) {
        number = static_cast<std::int32_t>(counts.size());
        counts.push_back(0);
        result[c].push_back({0, 0});
      }
      auto& mean = result[c][static_cast<std::size_t>(number)];
      const float share = 1 / ++counts[static_cast<std::size_t>(number)];
      mean.x += share * (x - mean.x);
      mean.y += share * (y - mean.y);
    }
  }
  return result;
}

/// The nearest and the median class of a square of a plane.
std::uint8_t nearestAndMedian(const std::uint8_t* bins, int side) {
  std::array<int, kDistanceBins + 1> counts{};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) ++counts[bins[y * kHalfSide + x]];
  }
  int nearest = 0, median = 0, up_to_median = counts[0];
  while (counts[nearest] == 0) ++nearest;
  while (2 * up_to_median < side * side) up_to_median += counts[++median];
  return static_cast<std::uint8_t>(nearest | median << 4);
}
static_assert(kDistanceBins < 16);

}  // namespace

std::vector<std::uint8_t> DistanceField::overview(const PlaneCell& tile, int side) const {
  const Mask seen = seenIn(tile);
  const Sites sites = halved(sitesAround(tile), static_cast<float>(kReach_m / cell_m_));
  const TilePlanes made = makePlanes(sites, halved(seen), kHalfSide, 2 * cell_m_);
  const int cells = kHalfSide / side;
  std::vector<std::uint8_t> squares;
  squares.reserve(kBevChannels * static_cast<std::size_t>(side * side));
  for (const std::size_t plane : made.plane_of) {
    const std::uint8_t* bins = made.planes.data() + plane * kHalfSide * kHalfSide;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x)
        squares.push_back(nearestAndMedian(bins + (y * kHalfSide + x) * cells, cells));
    }
  }
  return squares;
}

}  // namespace xview::search
