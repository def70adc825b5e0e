// SPDX-License-Identifier: BSD-3-Clause
// Large maps seen from afar.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/cells.h"
#include "base/parallel.h"
#include "search/distance_field.h"

namespace xview::search {

std::uint64_t checksumOf(const BevGrid& view) {
  std::uint64_t sum = view.known.size();
  const auto mix = [&](std::uint64_t value) {
    sum = (sum ^ value) * 0x9E3779B97F4A7C15ull;
    sum ^= sum >> 32;
  };
  const auto bits = [](auto number) {
    static_assert(sizeof number == sizeof(std::uint32_t));
    std::uint32_t word = 0;
    std::memcpy(&word, &number, sizeof word);
    return std::uint64_t{word};
  };
  const auto mixPoint = [&](auto x, auto y, float z) {
    mix((bits(x) << 32 | bits(y)) + bits(z) * 0xBF58476D1CE4E5B9ull);
  };
  for (const GroundCell& cell : view.known)
    mixPoint(cell.x, cell.y, cell.measured ? cell.z : -cell.z);
  for (const auto& samples : view.samples) {
    mix(samples.size());
    for (const BevSample& s : samples) mixPoint(s.x, s.y, s.z);
  }
  return sum;
}

namespace {

constexpr int kBits = 6;
static_assert(DistanceField::kTileCells == 1 << kBits);

void sortTiles(MapOverview& overview) {
  std::sort(overview.tiles.begin(), overview.tiles.end(),
            [](const auto& a, const auto& b) { return InRowOrder()(a.at, b.at); });
}

PlaneCell tileOf(const GroundCell& cell) { return {cell.x >> kBits, cell.y >> kBits}; }
PlaneCell tileOf(const BevSample& s, double cell_m) {
  return {floorToInt(s.x / cell_m) >> kBits, floorToInt(s.y / cell_m) >> kBits};
}

/// Tiles, and those up to `reach` tiles away.
CellIndex grown(const CellIndex& tiles, int reach) {
  CellIndex result;
  for (const PlaneCell& cell : tiles.cells()) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) result.findOrAdd(cell.x + dx, cell.y + dy);
    }
  }
  return result;
}

}  // namespace

MapOverview overviewOf(const DistanceField& field, int side, int threads) {
  MapOverview overview;
  for (const PlaneCell& at : field.tiles()) overview.tiles.push_back({at, {}});
  sortTiles(overview);
  parallelFor(overview.tiles.size(), threads, [&](std::size_t i) {
    overview.tiles[i].squares = field.overview(overview.tiles[i].at, side);
  });
  return overview;
}

std::shared_ptr<const MapOverview> overviewOfLarge(const BevGrid& map) {
  if (!DistanceField::fitsColumns(map.cell_m)) return nullptr;
  const DistanceField field(map);
  if (field.tiles().size() < MapOverview::kFewest) return nullptr;
  auto overview = std::make_shared<MapOverview>(overviewOf(field, MapOverview::kSide, 1));
  overview->checksum = checksumOf(map);
  return overview;
}

namespace {

double tileSide(double cell_m) { return DistanceField::kTileCells * cell_m; }

/// Tiles from one that changes to what it depends on.
int reachOfTiles(double cell_m) {
  return static_cast<int>(std::ceil(DistanceField::kRim_m / tileSide(cell_m)));
}

}  // namespace

double grownReach(double cell_m) {
  return (2 * reachOfTiles(cell_m) + 1) * tileSide(cell_m) + cell_m;
}

std::shared_ptr<const MapOverview> grownOverview(const MapOverview& before, const BevGrid& map,
                                                 const BevGrid& addition) {
  const double tile_m = tileSide(map.cell_m);
  const int reach = reachOfTiles(map.cell_m);
  const float shift_x = static_cast<float>(addition.origin_x - map.origin_x),
              shift_y = static_cast<float>(addition.origin_y - map.origin_y);
  CellIndex added;
  const auto add = [&](double x, double y) {  // whatever is rounded lies in one of these
    for (const double dx : {-map.cell_m, map.cell_m}) {
      for (const double dy : {-map.cell_m, map.cell_m})
        added.findOrAdd(floorToInt((x + shift_x + dx) / tile_m),
                        floorToInt((y + shift_y + dy) / tile_m));
    }
  };
  for (const GroundCell& cell : addition.known)
    add((cell.x + 0.5) * addition.cell_m, (cell.y + 0.5) * addition.cell_m);
  for (const auto& samples : addition.samples) {
    for (const BevSample& s : samples) add(double{s.x}, double{s.y});
  }
  const CellIndex changed = grown(added, reach), needed = grown(changed, reach);

  BevGrid part;
  part.cell_m = map.cell_m;
  for (const GroundCell& cell : map.known) {
    if (needed.contains(tileOf(cell))) part.known.push_back(cell);
  }
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (const BevSample& s : map.samples[c]) {
      if (needed.contains(tileOf(s, map.cell_m))) part.samples[c].push_back(s);
    }
  }
  auto overview = std::make_shared<MapOverview>();
  for (const MapOverview::Tile& tile : before.tiles) {
    if (!changed.contains(tile.at)) overview->tiles.push_back(tile);
  }
  const DistanceField field(part);
  for (const PlaneCell& at : field.tiles()) {
    if (changed.contains(at))
      overview->tiles.push_back({at, field.overview(at, MapOverview::kSide)});
  }
  sortTiles(*overview);
  overview->checksum = checksumOf(map);
  return overview;
}

}  // namespace xview::search
