// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "input_file.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "yaml_file.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "pointcloud_map_metadata.yaml";
constexpr const char* kTilesFolder = "pointcloud_map.pcd";  ///< as Autoware calls it
constexpr std::size_t kMostTiles = 50000;  ///< that are written; as many lines are read again

struct Tile {
  std::string path;
  Eigen::Array2d corner;  ///< lower one [m]
};

struct Tiling {
  std::string metadata;
  Eigen::Array2d size;  ///< of a tile [m]
  std::vector<Tile> tiles;
};

bool isTileName(const std::string& name) {
  return fs::path(name).filename() == name && name[0] != '.' && endingOf(name) == ".pcd";
}

/// The metadata as written; paths are names.
Tiling readMetadata(const std::string& path) {
  const YamlFile yaml = YamlFile::read(path);
  if (!yaml.root().IsMap()) yaml.fail(yaml.root(), "expected `key: value` lines");
  Tiling tiling{path, Eigen::Array2d::Zero(), {}};
  std::set<std::string> seen;
  for (const auto& entry : yaml.root()) {
    const std::string key = yaml.text(entry.first, "a key");
    if (!seen.insert(key).second) yaml.fail(entry.first, io::inQuotes(key) + " a second time");
    if (key == "x_resolution" || key == "y_resolution") {
      tiling.size[key[0] - 'x'] = yaml.number(entry.second, key);
    } else if (isTileName(key)) {
      if (!entry.second.IsSequence() || entry.second.size() != 2)
        yaml.fail(entry.first, io::inQuotes(key) + ": expected its lower corner [x, y]");
      const auto at = [&](int axis) { return yaml.number(entry.second[axis], key + "'s corner"); };
      tiling.tiles.push_back({key, {at(0), at(1)}});
    } else {
      yaml.fail(entry.first,
                "expected x_resolution, y_resolution or the name of a .pcd in the "
                "folder, found " +
                    io::inQuotes(key));
    }
  }
  if (!(tiling.size > 0).all())
    yaml.fail(yaml.root(), "expected x_resolution and y_resolution above 0");
  if (tiling.tiles.empty()) yaml.fail(yaml.root(), "lists no tiles (`NAME.pcd: [x, y]`)");
  return tiling;
}

/// That of the folder itself, else the one beside it.
std::string metadataOf(const fs::path& folder) {
  if (fs::exists(folder / kMetadata)) return (folder / kMetadata).string();
  return (fs::canonical(folder).parent_path() / kMetadata).string();
}

/// Where the tiles lie: in the given folder, else in the one below it that has the first of them.
fs::path folderOfTiles(const fs::path& given, const Tiling& tiling) {
  const std::string& first = tiling.tiles.front().path;
  std::set<fs::path> folders;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(given, failed))
    if (entry.is_directory() && fs::exists(entry.path() / first, failed))
      folders.insert(entry.path());
  return fs::exists(given / first, failed) || folders.empty() ? given : *folders.begin();
}

Tiling readTiling(const std::string& path) {
  Tiling tiling = readMetadata(metadataOf(path));
  const fs::path folder = folderOfTiles(path, tiling);
  for (Tile& tile : tiling.tiles) {
    const fs::path file = folder / tile.path;
    std::error_code failed;
    if (!fs::is_regular_file(file, failed))
      throw Error(tiling.metadata, "lists " + io::inQuotes(tile.path) +
                                       ", but there is no such file in " + folder.string() +
                                       "; copy it there or take its line out");
    tile.path = file.string();
  }
  return tiling;
}

/// The first file beside the tiles that the metadata does not list, by name; empty if there is
/// none.
std::string unlistedOf(const Tiling& tiling) {
  std::set<std::string> files;
  std::error_code failed;
  const fs::path folder = fs::path(tiling.tiles[0].path).parent_path();
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file() && endingOf(entry.path().string()) == ".pcd")
      files.insert(entry.path().string());
  for (const Tile& tile : tiling.tiles) files.erase(tile.path);
  return files.empty() ? "" : *files.begin();
}

/// Where a tile lies is known to the rounding of its points, and to a thinning of them.
void requireInside(const Tiling& tiling, const Tile& tile, const LabelledCloud& cloud) {
  constexpr double kTolerance = 0.01;  ///< of the size
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Array2d p = cloud.position(i).head<2>().array();
    const Eigen::Array2d share = (p - tile.corner) / tiling.size;
    if ((share >= -kTolerance).all() && (share <= 1 + kTolerance).all()) continue;
    throw Error(tile.path,
                fmt::format("has a point at x {:.2f}, y {:.2f}, outside of the {} x {} m "
                            "from [{}, {}] that {} gives it; correct its line there",
                            p.x(), p.y(), tiling.size.x(), tiling.size.y(), tile.corner.x(),
                            tile.corner.y(), tiling.metadata));
  }
}

/// Positions of the points in each tile of a grid, by column and row.
using Grid = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>>;

Grid gridOf(const LabelledCloud& cloud, int size_m) {
  Grid grid;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.position(i) / size_m;
    grid[{static_cast<std::int64_t>(std::floor(p.x())),
          static_cast<std::int64_t>(std::floor(p.y()))}]
        .push_back(i);
    if (grid.size() > kMostTiles)
      throw UsageError(
          fmt::format("tiles of {} m would be more than {}; make them larger", size_m, kMostTiles));
  }
  return grid;
}

}  // namespace

bool isTiledCloud(const std::string& path) {
  std::error_code failed;
  if (!fs::is_directory(path, failed)) return false;
  if (fs::exists(fs::path(path) / kMetadata)) return true;
  const std::string beside = metadataOf(path);
  if (!fs::exists(beside) || fs::exists(fs::path(path) / "poses.txt")) return false;
  return fs::exists(fs::path(path) / readMetadata(beside).tiles.front().path);
}

std::string firstTile(const std::string& path) { return readTiling(path).tiles.front().path; }

CloudHeader readTiledHeader(const std::string& path, const CloudFields& fields) {
  const Tiling tiling = readTiling(path);
  CloudHeader all = readCloudHeader(tiling.tiles.front().path, fields);
  all.points = 0;
  for (const Tile& tile : tiling.tiles) {
    const CloudHeader one = readCloudHeader(tile.path, fields);
    all.points += one.points;
    if (all.points > std::numeric_limits<std::int32_t>::max())  // PCL counts in int
      throw Error(path, "has more than 2^31 points");
    // Where no point of a tile has an instance, the tile has no field of them.
    if (all.instance_field.empty()) all.instance_field = one.instance_field;
    const bool has_instances = !one.instance_field.empty();
    if (one.label_field != all.label_field ||
        (has_instances && one.instance_field != all.instance_field))
      throw Error(tile.path,
                  fmt::format("has its classes and instances in the fields '{}' and "
                              "'{}', but {} in '{}' and '{}'",
                              one.label_field, one.instance_field, tiling.tiles.front().path,
                              all.label_field, all.instance_field));
  }
  all.format = fmt::format("{} tiles of {} x {} m, {}", tiling.tiles.size(), tiling.size.x(),
                           tiling.size.y(), all.format);
  if (const std::string file = unlistedOf(tiling); !file.empty())
    all.notes.push_back(io::inQuotes(fs::path(file).filename().string()) +
                        " is left out, because " + kMetadata + " does not list it");
  return all;
}

LabelledCloud readTiledCloud(const std::string& path, const CloudFields& fields,
                             bool require_label) {
  LabelledCloud all;
  LeftOut left_out;
  all.points.reserve(readTiledHeader(path, fields).points);
  const Tiling tiling = readTiling(path);
  for (const Tile& tile : tiling.tiles) {
    const LabelledCloud cloud = readCloud(tile.path, fields, require_label);
    requireInside(tiling, tile, cloud);
    all.append(cloud);
    left_out += cloud.left_out;
  }
  all.left_out = left_out;
  return all;
}

void writeTiles(const std::string& folder, const LabelledCloud& cloud, int size_m,
                const LabelSet* labels) {
  const Grid grid = gridOf(cloud, size_m);
  AtomicFolder whole(folder);
  const std::string root = whole.temporaryPath() + "/";
  makeFolder(root + kTilesFolder);
  std::string metadata = fmt::format("x_resolution: {0}\ny_resolution: {0}\n", size_m);
  for (const auto& [place, points] : grid) {
    LabelledCloud tile;
    tile.origin = cloud.origin;
    for (const std::size_t i : points) tile.points.push_back(cloud.points[i]);
    const std::string name = fmt::format("tile_{}_{}.pcd", place.first, place.second);
    writePcd(root + kTilesFolder + "/" + name, tile, labels);
    metadata += fmt::format("{}: [{}, {}]\n", name, place.first * size_m, place.second * size_m);
  }
  writeFile(root + kMetadata, metadata);
  whole.commit({kTilesFolder, kMetadata});
}

}  // namespace xview::io
