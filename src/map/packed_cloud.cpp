// SPDX-License-Identifier: BSD-3-Clause
#include "packed_cloud.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/cells.h"
#include "map/contents.h"
#include "map_tables.h"
#include "place/bev_grid.h"
#include "search/distance_field.h"
#include "xview/base/error.h"

namespace xview::map {
namespace {

/// A column is asked for once for each tile of distributions in it; columns of the view are for the
/// obstacles around each place that is looked at.
constexpr std::size_t kMostRecent = 8, kMostRecentOfView = 64;

PlaneCell columnOf(const Tile& tile) {
  return {static_cast<std::int32_t>(tile.x), static_cast<std::int32_t>(tile.y)};
}

/// Points in canonical lengths, from the origin of the cloud, are added to a map.
void append(LabelledCloud points, SemanticMap& map) {
  points.origin = map.cloud.origin / map.size;
  scaleLengths(map.size, points);
  map.cloud.append(points);
}

/// Moves the tiles that are `wanted` into the cloud of the map.
template <class IsWanted>
void unpack(const PackedCloud& packed, const IsWanted& isWanted, SemanticMap& map) {
  std::vector<Tile> left;
  LabelledCloud points;
  std::size_t count = 0;
  for (const Tile& tile : packed.tiles()) count += isWanted(tile) ? tile.points : 0;
  points.points.reserve(count);
  for (const Tile& tile : packed.tiles()) {
    if (isWanted(tile))
      appendTile(tile, points);
    else
      left.push_back(tile);
  }
  map.stored_points =
      left.empty() ? nullptr : std::make_shared<const PackedCloud>(std::move(left), packed.file());
  append(std::move(points), map);
}

/// What the tiles of a column add to `empty`, unpacked unless that was done lately.
template <class Content>
std::shared_ptr<const Content> unpackedColumn(const PlaneCell& column,
                                              const std::vector<Tile>& tiles,
                                              const TilesOfColumns& tiles_of,
                                              const std::string& file, const Content& empty,
                                              RecentColumns<Content>& recent) {
  return recent.findOrMake(column, [&] {
    auto content = std::make_shared<Content>(empty);
    rethrowDamage(file, [&] {
      for (const std::size_t i : tiles_of.in(column)) appendTile(tiles[i], *content);
    });
    return content;
  });
}

}  // namespace

TilesOfColumns::TilesOfColumns(const std::vector<Tile>& tiles) {
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const PlaneCell column = columnOf(tiles[i]);
    tiles_of_[{column.y, column.x}].push_back(i);
  }
}

std::vector<PlaneCell> TilesOfColumns::columns() const {
  std::vector<PlaneCell> columns;
  for (const auto& [key, tiles] : tiles_of_) columns.push_back({key.second, key.first});
  return columns;
}

const std::vector<std::size_t>& TilesOfColumns::in(const PlaneCell& column) const {
  static const std::vector<std::size_t> kNone;
  const auto found = tiles_of_.find({column.y, column.x});
  return found == tiles_of_.end() ? kNone : found->second;
}

PackedCloud::PackedCloud(std::vector<Tile> tiles, std::string file)
    : tiles_(std::move(tiles)), file_(std::move(file)), tiles_of_(tiles_), recent_(kMostRecent) {
  for (const Tile& tile : tiles_) points_ += tile.points;
}

std::vector<PlaneCell> PackedCloud::columns() const { return tiles_of_.columns(); }

std::shared_ptr<const LabelledCloud> PackedCloud::pointsOf(const PlaneCell& column) const {
  return unpackedColumn(column, tiles_, tiles_of_, file_, LabelledCloud(), recent_);
}

PackedBev::PackedBev(std::vector<Tile> tiles, BevGrid grid, std::string file, std::size_t samples,
                     std::uint64_t fingerprint)
    : tiles_(std::move(tiles)),
      grid_(std::move(grid)),
      file_(std::move(file)),
      samples_(samples),
      fingerprint_(fingerprint),
      tiles_of_(tiles_),
      recent_(kMostRecentOfView) {}

std::shared_ptr<const BevGrid> PackedBev::partOf(const PlaneCell& column) const {
  return unpackedColumn(column, tiles_, tiles_of_, file_, grid_, recent_);
}

const BevGrid& PackedBev::whole() const {
  std::call_once(unpacked_, [&] {
    rethrowDamage(file_, [&] {
      BevGrid whole = grid_;
      fill(tiles_, whole);
      if (whole.sampleCount() != samples_) throw Damage("plan_samples: not as many as expected");
      whole_ = std::move(whole);
    });
  });
  return whole_;
}

std::shared_ptr<const PackedBev> PackedBev::changed(const CellIndex& columns, const BevGrid& former,
                                                    const BevGrid& now) const {
  const auto isThere = [&](const Tile& tile) {
    const PlaneCell column = columnOf(tile);
    return columns.find(column.x, column.y) >= 0;
  };
  std::vector<Tile> tiles = toTiles(now);
  if (!std::all_of(tiles.begin(), tiles.end(), isThere)) return nullptr;
  std::vector<Tile> others;
  for (const Tile& tile : tiles_) {
    if (!isThere(tile)) others.push_back(tile);
  }
  mergeTiles(others, tiles);
  return std::make_shared<const PackedBev>(
      std::move(tiles), grid_, file_, samples_ - former.sampleCount() + now.sampleCount(),
      search::fingerprintOfSum(fingerprint_ - search::fingerprintOf(former),
                               search::fingerprintOf(now)));
}

const PackedBev* packedBevOf(const SemanticMap& map) {
  return dynamic_cast<const PackedBev*>(map.stored_view.get());
}

const BevGrid& viewOf(const SemanticMap& map) {
  return map.stored_view ? map.stored_view->whole() : map.bev;
}

namespace {

/// What was measured of a view stays that of the map's, which differs by rounding or packing only.
void keepMeasured(bool is_measured, bool has_overview, SemanticMap& map) {
  if (is_measured) map.null.view = search::fingerprintOf(map.bev);
  if (!has_overview) return;
  auto overview = *map.overview;
  overview.checksum = search::checksumOf(map.bev);
  map.overview = std::make_shared<const search::MapOverview>(std::move(overview));
}

}  // namespace

void unpackView(SemanticMap& map) {
  if (!map.stored_view) return;
  map.bev = map.stored_view->whole();
  keepMeasured(map.null.view == map.stored_view->fingerprint(), map.overview != nullptr, map);
  map.stored_view.reset();
}

SemanticMap unpacked(SemanticMap map) {
  unpackPoints(map);
  unpackView(map);
  unpackVertices(map);
  return map;
}

bool hasOverview(const SemanticMap& map) {
  return map.overview && map.size == kTownScale &&
         map.overview->checksum == search::checksumOf(map.bev);
}

search::MapView searchedView(const SemanticMap& map) {
  const bool is_known = map.stored_view || hasOverview(map);
  return {map.bev, map.stored_view, is_known ? map.overview : nullptr};
}

bool hasView(const SemanticMap& map) { return map.stored_view || !map.bev.known.empty(); }

std::shared_ptr<const BevGrid> viewWithin(const Eigen::AlignedBox2d& box, const SemanticMap& map) {
  if (!map.stored_view) return {std::shared_ptr<const BevGrid>(), &map.bev};
  const Eigen::Vector2d origin(map.bev.origin_x, map.bev.origin_y);
  CellIndex columns;
  addColumns({box.min() - origin, box.max() - origin}, columns);
  return std::make_shared<const BevGrid>(gathered(*map.stored_view, columns, map.bev));
}

std::uint64_t fingerprintOfView(const SemanticMap& map) {
  return map.stored_view ? map.stored_view->fingerprint() : search::fingerprintOf(map.bev);
}

namespace {

/// The columns in which something of an addition may lie, and those that its overview is made of.
CellIndex columnsAround(const BevGrid& addition, const BevGrid& grid) {
  constexpr double kSide_m = 16;  // of squares in which additions are looked for
  const auto rim = Eigen::Vector2d::Constant(search::grownReach(grid.cell_m));
  const Eigen::Vector2d shift(addition.origin_x - grid.origin_x, addition.origin_y - grid.origin_y);
  CellIndex near, columns;
  const auto add = [&](double x, double y) {
    const Eigen::Vector2d p = shift + Eigen::Vector2d(x, y);
    near.findOrAdd(floorToInt(p.x() / kSide_m), floorToInt(p.y() / kSide_m));
  };
  for (const GroundCell& cell : addition.known)
    add((cell.x + 0.5) * addition.cell_m, (cell.y + 0.5) * addition.cell_m);
  for (const auto& samples : addition.samples) {
    for (const BevSample& s : samples) add(double{s.x}, double{s.y});
  }
  for (const PlaneCell& tile : near.cells()) {
    const Eigen::Vector2d low = kSide_m * Eigen::Vector2d(tile.x, tile.y);
    addColumns({low - rim, low + Eigen::Vector2d::Constant(kSide_m) + rim}, columns);
  }
  return columns;
}

/// False, and nothing changed, if the view must be unpacked.
bool growStoredView(const BevGrid& addition, SemanticMap& map) {
  const PackedBev* packed = packedBevOf(map);
  if (!packed || !map.overview) return false;
  const CellIndex columns = columnsAround(addition, map.bev);
  const BevGrid former = gathered(*packed, columns, map.bev);
  if (former.known.empty()) return false;  // merged, it would have the grid of the addition
  BevGrid now = former;
  mergeBevGrids(now, addition);
  auto changed = packed->changed(columns, former, now);
  if (!changed) return false;
  map.overview = search::grownOverview(*map.overview, now, addition);
  map.stored_view = std::move(changed);
  return true;
}

}  // namespace

void growView(const BevGrid& addition, SemanticMap& map) {
  if (addition.known.empty() || growStoredView(addition, map)) return;
  unpackView(map);
  const bool had_overview = hasOverview(map);
  mergeBevGrids(map.bev, addition);
  if (had_overview) map.overview = search::grownOverview(*map.overview, map.bev, addition);
}

const PackedCloud* packedCloudOf(const SemanticMap& map) {
  return dynamic_cast<const PackedCloud*>(map.stored_points.get());
}

void unpackPoints(SemanticMap& map) {
  const auto stored = map.stored_points;  // for as long as it is read
  if (!stored) return;
  if (const PackedCloud* packed = packedCloudOf(map)) {
    const auto all = [](const Tile&) { return true; };
    return rethrowDamage(packed->file(), [&] { unpack(*packed, all, map); });
  }
  LabelledCloud points;
  for (const PlaneCell& column : stored->columns()) points.append(*stored->pointsOf(column));
  map.stored_points.reset();
  append(std::move(points), map);
}

void unpackPointsAround(const LabelledCloud& near, SemanticMap& map) {
  const auto stored = map.stored_points;  // for as long as it is read
  const PackedCloud* packed = packedCloudOf(map);
  if (!packed) return unpackPoints(map);
  std::set<std::pair<std::int32_t, std::int32_t>> columns;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const Eigen::Vector3d p = (near.position(i) - map.cloud.origin) / map.size;
    if (p.allFinite())
      columns.insert(
          {floorToInt(p.x() / StoredCloud::kColumn_m), floorToInt(p.y() / StoredCloud::kColumn_m)});
  }
  const auto isNear = [&](const Tile& tile) {
    const PlaneCell column = columnOf(tile);
    return columns.count({column.x, column.y}) > 0;
  };
  rethrowDamage(packed->file(), [&] { unpack(*packed, isNear, map); });
}

void roundAsStored(SemanticMap& map) {
  const bool is_measured = map.null.view == fingerprintOfView(map), had_overview = hasOverview(map);
  const double step = map.size / kStoredSteps;
  const auto round = [&](float& coordinate) {
    coordinate = static_cast<float>(std::round(coordinate / step) * step);
  };
  for (std::vector<BevSample>& samples : map.bev.samples) {
    for (BevSample& sample : samples) {
      for (float* const coordinate : {&sample.x, &sample.y, &sample.z}) round(*coordinate);
    }
  }
  for (GroundCell& cell : map.bev.known) round(cell.z);
  for (Point& point : map.cloud.points) {
    for (float& coordinate : point.getVector3fMap()) round(coordinate);
  }
  keepMeasured(is_measured, had_overview, map);
}

void packPoints(SemanticMap& map) {
  if (map.size != kTownScale) throw UsageError("only points of canonical scale are packed");
  std::vector<Tile> tiles = toTiles(map.cloud);
  if (const PackedCloud* packed = packedCloudOf(map)) mergeTiles(packed->tiles(), tiles);
  map.stored_points = std::make_shared<const PackedCloud>(std::move(tiles), "");
  map.cloud.points = {};
}

std::uint64_t checksumOf(const SemanticMap& map) {
  if (map.checksum != 0) return map.checksum;
  ContentHash hash;
  hash.add(static_cast<std::int64_t>(fingerprintOfView(map)));
  hash.add(map.size);
  for (const double coordinate : map.cloud.origin) hash.add(coordinate);
  for (const Eigen::Isometry3d& T : map.poses) {
    for (const double number : T.matrix().reshaped()) hash.add(number);
  }
  for (const auto& [id, info] : map.labels.classes()) hash.add(info.name.data(), info.name.size());
  allVertices(map).forEach([&](std::uint32_t, const Vertex& v) {
    hash.add(static_cast<std::int64_t>(v.label));
    for (const double coordinate : v.position) hash.add(coordinate);
  });
  const auto add = [&](const LabelledCloud& points) {
    for (const Point& p : points.points) {
      hash.add(static_cast<std::int64_t>(p.label));
      for (const float coordinate : p.getVector3fMap()) hash.add(double{coordinate});
    }
  };
  forPoints(
      map, [](const PlaneCell&) { return true; }, add);
  return static_cast<std::uint64_t>(hash.value());
}

Counts countsOf(const SemanticMap& map) {
  return {allVertices(map).size(),
          map.cloud.size() + (map.stored_points ? map.stored_points->size() : 0),
          map.stored_view ? map.stored_view->sampleCount() : map.bev.sampleCount()};
}

}  // namespace xview::map
