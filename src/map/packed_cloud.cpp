// SPDX-License-Identifier: BSD-3-Clause
#include "packed_cloud.h"

#include <algorithm>
#include <set>

#include "xview/types/cells.h"
#include "xview/types/error.h"

namespace xview::map {
namespace {

/// A column is asked for once for each tile of distributions in it.
constexpr std::size_t kMostRecent = 8;

PlaneCell columnOf(const Tile& tile) {
  return {static_cast<std::int32_t>(tile.x), static_cast<std::int32_t>(tile.y)};
}

/// Moves the tiles that are `wanted` into the cloud of the map.
template <class IsWanted>
void unpack(SemanticMap& map, const IsWanted& isWanted) {
  if (!map.packed) return;
  std::vector<Tile> left;
  LabelledCloud points;
  std::size_t count = 0;
  for (const Tile& tile : map.packed->tiles()) count += isWanted(tile) ? tile.points : 0;
  points.points.reserve(count);
  for (const Tile& tile : map.packed->tiles()) {
    if (isWanted(tile))
      appendTile(tile, points);
    else
      left.push_back(tile);
  }
  map.packed = left.empty()
                   ? nullptr
                   : std::make_shared<const PackedCloud>(std::move(left), map.packed->file());
  points.origin = map.cloud.origin / map.size;
  scaleLengths(map.size, points);
  map.cloud.append(points);
}

/// Runs `work`; damage of the file becomes an Error.
template <class Work>
void orError(const std::string& file, const Work& work) {
  try {
    work();
  } catch (const Damage& e) {
    throw Error(file, std::string("damaged map file: ") + e.what());
  }
}

}  // namespace

PackedCloud::PackedCloud(std::vector<Tile> tiles, std::string file)
    : tiles_(std::move(tiles)), file_(std::move(file)) {
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const PlaneCell column = columnOf(tiles_[i]);
    tiles_of_[{column.y, column.x}].push_back(i);
    points_ += tiles_[i].points;
  }
}

std::vector<PlaneCell> PackedCloud::columns() const {
  std::vector<PlaneCell> columns;
  for (const auto& [key, tiles] : tiles_of_) columns.push_back({key.second, key.first});
  return columns;
}

std::shared_ptr<const LabelledCloud> PackedCloud::pointsOf(const PlaneCell& column) const {
  const Key key{column.y, column.x};
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = std::find_if(recent_.begin(), recent_.end(),
                                    [&](const Unpacked& u) { return u.first == key; });
    if (known != recent_.end()) {
      recent_.splice(recent_.begin(), recent_, known);
      return known->second;
    }
  }
  auto points = std::make_shared<LabelledCloud>();
  if (const auto found = tiles_of_.find(key); found != tiles_of_.end()) {
    orError(file_, [&] {
      for (const std::size_t i : found->second) appendTile(tiles_[i], *points);
    });
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  recent_.emplace_front(key, points);
  if (recent_.size() > kMostRecent) recent_.pop_back();
  return points;
}

void unpackAll(SemanticMap& map) {
  unpack(map, [](const Tile&) { return true; });
}

void unpackPoints(SemanticMap& map) {
  if (map.packed) orError(std::string(map.packed->file()), [&] { unpackAll(map); });
}

void unpackPointsAround(const LabelledCloud& near, SemanticMap& map) {
  if (!map.packed) return;
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
  orError(std::string(map.packed->file()), [&] { unpack(map, isNear); });
}

void packPoints(SemanticMap& map) {
  if (map.size != kTownScale) throw UsageError("only points of canonical scale are packed");
  std::vector<Tile> tiles = toTiles(map.cloud);
  if (map.packed) mergeTiles(map.packed->tiles(), tiles);
  map.packed = std::make_shared<const PackedCloud>(std::move(tiles), "");
  map.cloud.points = {};
}

const StoredCloud* storedPoints(const SemanticMap& map) { return map.packed.get(); }

std::size_t pointCount(const SemanticMap& map) {
  return map.cloud.size() + (map.packed ? map.packed->size() : 0);
}

}  // namespace xview::map
