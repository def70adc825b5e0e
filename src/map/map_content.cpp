// SPDX-License-Identifier: BSD-3-Clause
// What stands in each table of a map, for writing and for reading.
#include "map_tables.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "base/pose.h"
#include "base/user_text.h"
#include "map/contents.h"
#include "packed_cloud.h"
#include "packed_vertices.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"

namespace xview::map {
namespace {

// ---- columns behind the key, in the order of the table

/// A row of the tables meta (value) and checksums (content).
template <class Value>
struct NamedRow {
  std::string name;
  Value value{};
};

template <class Row, class Value>
void columns(Row& row, NamedRow<Value>& named) {
  row(named.name);
  row(named.value);
}

template <class Row>
void columns(Row& row, ClassInfo& info) {
  row(info.name);
  for (std::uint8_t& channel : info.color) row(channel);
  row.named(info.role, Role::ignored, "role");
  row.named(info.kind, Kind::none, "kind");
  row(info.guessed);
}

template <class Row>
void columns(Row& row, std::string& source) {
  row(source);
}

struct Keyframe {
  std::int64_t number = 0;
  double stamp_s = 0;
  std::uint32_t source = 0;
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
};

template <class Row>
void columns(Row& row, Keyframe& k) {
  row(k.number);
  row(k.stamp_s);
  row(k.source);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) row(k.T_map_sensor.matrix()(i, j));
  }
}

template <class Row>
void columns(Row& row, Vertex& v) {
  row(v.label);
  row(v.instance);
  for (double& coordinate : v.position) row(coordinate);
  for (double& length : v.extent) row(length);
  row(v.sigma_m);
  row(v.observations);
  row(v.points);
  row(v.first_frame);
  row(v.last_frame);
}

// ---- tables

/// Writes the tables one after the other and the hash of each at the end.
class ContentWriter {
 public:
  ContentWriter(SQLite::Database& database, std::string schema)
      : database_(database), schema_(std::move(schema)) {}

  /// One row per item; id(item, index) gives its key.
  template <class Item, class Id>
  void table(const std::string& name, const std::vector<Item>& items, Id&& id) {
    RowWriter row(database_, schema_ + "." + name);
    for (std::size_t i = 0; i < items.size(); ++i) {
      row(static_cast<std::int64_t>(id(items[i], i)));
      Item copy = items[i];
      columns(row, copy);
      row.endRow();
    }
    hashes_.push_back({name, row.hash()});
  }

  /// Rows whose ids count from zero.
  template <class Item>
  void table(const std::string& name, const std::vector<Item>& items) {
    table(name, items, [](const Item&, std::size_t i) { return i; });
  }

  void finish() { table("checksums", std::vector<NamedRow<std::int64_t>>(hashes_)); }

 private:
  SQLite::Database& database_;
  std::string schema_;
  std::vector<NamedRow<std::int64_t>> hashes_;
};

class ContentReader {
 public:
  explicit ContentReader(SQLite::Database& database) : database_(database) {
    rows<NamedRow<std::int64_t>>("checksums", [&](std::int64_t, NamedRow<std::int64_t>& checksum) {
      hashes_[checksum.name] = checksum.value;
    });
  }

  std::uint64_t checksum() const {
    ContentHash all;
    for (const auto& [name, hash] : hashes_) all.add(hash);
    return static_cast<std::uint64_t>(all.value());
  }

  /// take(id, item) receives each row.
  template <class Item, class Take>
  void table(const std::string& name, Take&& take) {
    const RowReader row = rows<Item>(name, take);
    const auto hash = hashes_.find(name);
    if (hash == hashes_.end()) throw Damage("no checksum of table " + name);
    row.verify(hash->second);
  }

  /// Rows whose ids count from zero.
  template <class Item>
  void items(const std::string& name, std::vector<Item>& all) {
    table<Item>(name, [&](std::int64_t id, Item& item) {
      if (id != static_cast<std::int64_t>(all.size()))
        throw Damage("table " + name + " misses a row");
      all.push_back(std::move(item));
    });
  }

 private:
  template <class Item, class Take>
  RowReader rows(const std::string& name, Take&& take) {
    RowReader row(database_, name);
    while (row.nextRow()) {
      std::int64_t id = 0;
      row(id);
      Item item;
      columns(row, item);
      take(id, item);
    }
    return row;
  }

  SQLite::Database& database_;
  std::map<std::string, std::int64_t> hashes_;
};

// ---- the table of single values, as text

using Meta = std::map<std::string, std::string>;
constexpr std::uint64_t kAnyNumber = std::numeric_limits<std::uint64_t>::max();

/// visit(name, number) for the real numbers of a map, in both directions.
template <class Map, class Visit>
void forEachNumber(Map& map, Visit&& visit) {
  visit("cloud_origin_x", map.cloud.origin.x());
  visit("cloud_origin_y", map.cloud.origin.y());
  visit("cloud_origin_z", map.cloud.origin.z());
  visit("plan_cell_m", map.bev.cell_m);
  visit("plan_origin_x", map.bev.origin_x);
  visit("plan_origin_y", map.bev.origin_y);
  visit("plan_origin_z", map.bev.origin_z);
  visit("plan_upright_w", map.bev.alignment.w());
  visit("plan_upright_x", map.bev.alignment.x());
  visit("plan_upright_y", map.bev.alignment.y());
  visit("plan_upright_z", map.bev.alignment.z());
}

/// In the text of wrong places: what was not asked.
constexpr const char* kNotAsked = "-";

/// Two numbers of each wrong place, with blanks between them.
std::string textOf(const std::vector<WrongPlace>& wrong_places,
                   std::optional<double> WrongPlace::*first,
                   std::optional<double> WrongPlace::*second) {
  std::string all;
  for (const WrongPlace& place : wrong_places) {
    for (const std::optional<double>& value : {place.*first, place.*second})
      all += (value ? numberText(*value) : kNotAsked) + ' ';
  }
  return all;
}

/// Two numbers each, way and confidence, with blanks between them.
std::string textOf(const std::vector<OwnStretch>& stretches) {
  std::string all;
  for (const OwnStretch& s : stretches)
    all += numberText(s.window_m) + ' ' + numberText(s.confidence) + ' ';
  return all;
}

/// The number of poses and the view, then the counts by channel and class.
std::string textOf(const search::PathNull& null) {
  std::string all = std::to_string(null.poses) + ' ' + std::to_string(null.view);
  for (const auto& channel : null.counts) {
    for (const double count : channel) all += ' ' + numberText(count);
  }
  return all;
}

/// Cell size, thickness and whether it is sparse.
std::string textOf(const std::optional<pose::SurfaceNoise>& noise) {
  if (!noise) return kNotAsked;
  return numberText(noise->cell_m) + ' ' + numberText(noise->thickness_m) + ' ' +
         (noise->is_sparse ? "1" : "0");
}

/// Edges of a radius are made anew.
bool storesEdges(const SemanticGraph& graph) { return graph.edge_radius_m == 0; }

/// `points`: of the cloud, which is thinned on its way into the file.
Meta metaOf(const SemanticMap& map, std::size_t points) {
  Meta meta{
      {"graph_space", toString(map.graph.space)},
      {"program_version", XVIEW_VERSION},
      {"label_set", map.labels.name()},
      {"options", map.options_yaml},
      {"wrong_places", textOf(map.wrong_places, &WrongPlace::above_null, &WrongPlace::miss_ratio)},
      {"wrong_margins",
       textOf(map.wrong_places, &WrongPlace::dense_margin, &WrongPlace::likelihood_margin)},
      {"own_stretches", textOf(map.own_stretches)},
      {"null", textOf(map.null)},
      {"size", sizeText(map.size)},
      {"vertices", std::to_string(countsOf(map).vertices)},
      {"edges", std::to_string(storesEdges(map.graph) ? map.graph.edgeCount() : 0)},
      {"edge_radius_m", numberText(map.graph.edge_radius_m)},
      {"noise", textOf(map.noise)},
      {"keyframes", std::to_string(map.poses.size())},
      {"cloud_points", std::to_string(points)},
      {"plan_samples", std::to_string(countsOf(map).samples)},
      {"plan_view", std::to_string(fingerprintOfView(map))},
      {"plan_channels", channelNames()},
      {"plan_aerial", map.bev.aerial ? "1" : "0"}};
  forEachNumber(map, [&](const char* name, double value) { meta[name] = numberText(value); });
  return meta;
}

const std::string& textIn(const Meta& meta, const std::string& name) {
  const auto found = meta.find(name);
  if (found == meta.end()) throw Damage("meta: no " + name);
  return found->second;
}

template <class Number>
Number numberIn(const Meta& meta, const std::string& name) {
  const std::string& text = textIn(meta, name);
  const auto value = numberFrom<Number>(text);
  if (!value) throw Damage("meta: " + name + " is no number: " + text);
  return *value;
}

/// Files of the first programs do not tell: their graphs are of cloud space.
GraphSpace graphSpaceIn(const Meta& meta) {
  const auto found = meta.find("graph_space");
  if (found == meta.end()) return GraphSpace::cloud;
  if (const auto space = enumeratorNamed(found->second, GraphSpace::image)) return *space;
  throw Damage("meta: unknown graph_space " + found->second);
}

/// Maps that do not say it are of a town.
double sizeIn(const Meta& meta) {
  const auto found = meta.find("size");
  if (found == meta.end()) return kTownScale;
  try {
    return parseSize(found->second).value_or(kTownScale);
  } catch (const UsageError& e) {
    throw Damage(std::string("meta: ") + e.what());
  }
}

/// The pairs of textOf; none in files of older programs.
std::vector<std::array<std::optional<double>, 2>> pairsIn(const Meta& meta, const std::string& name,
                                                          double most) {
  std::vector<std::array<std::optional<double>, 2>> all;
  const auto found = meta.find(name);
  if (found == meta.end()) return all;
  std::istringstream words(found->second);
  const auto value = [&](const std::string& word) -> std::optional<double> {
    if (word == kNotAsked) return std::nullopt;
    const auto number = numberFrom<double>(word);
    if (number && std::abs(*number) <= most) return number;
    throw Damage("meta: " + name + " has a number out of range: " + word);
  };
  for (std::string first, second; words >> first;) {
    if (!(words >> second)) throw Damage("meta: " + name + " are no pairs");
    all.push_back({value(first), value(second)});
  }
  return all;
}

std::vector<WrongPlace> wrongPlacesIn(const Meta& meta) {
  constexpr double kMostMargin = 1e9;
  std::vector<WrongPlace> all;
  for (const auto& [above_null, miss_ratio] : pairsIn(meta, "wrong_places", 1))
    all.push_back({above_null, miss_ratio, {}, {}});
  const auto margins = pairsIn(meta, "wrong_margins", kMostMargin);
  if (!margins.empty() && margins.size() != all.size())
    throw Damage("meta: wrong_margins are not as many as wrong_places");
  for (std::size_t i = 0; i < margins.size(); ++i) {
    all[i].dense_margin = margins[i][0];
    all[i].likelihood_margin = margins[i][1];
  }
  return all;
}

/// None in files of older programs.
std::vector<OwnStretch> ownStretchesIn(const Meta& meta) {
  std::vector<OwnStretch> all;
  const auto found = meta.find("own_stretches");
  if (found == meta.end()) return all;
  std::istringstream words(found->second);
  for (std::string window, confidence; words >> window;) {
    words >> confidence;
    const auto window_m = numberFrom<double>(window), p = numberFrom<double>(confidence);
    if (!window_m || !(*window_m > 0) || !p || !(*p >= 0 && *p <= 1))
      throw Damage("meta: own_stretches has no length and confidence: " + window);
    all.push_back({*window_m, *p});
  }
  return all;
}

/// Nothing in files of older programs, and of such that sort distances into other classes.
search::PathNull pathNullIn(const Meta& meta) {
  const auto found = meta.find("null");
  if (found == meta.end()) return {};
  std::istringstream words(found->second);
  std::vector<double> counts;
  for (std::string word; words >> word;) {
    const auto count = numberFrom<double>(word);
    if (!count || !(*count >= 0) || !(*count <= 0x1p53))
      throw Damage("meta: null has no count: " + word);
    counts.push_back(*count);
  }
  search::PathNull null;
  if (counts.size() != 2 + null.counts.size() * null.counts[0].size()) return {};
  auto next = counts.begin();
  null.poses = static_cast<std::size_t>(*next++);
  null.view = static_cast<std::uint64_t>(*next++);
  for (auto& channel : null.counts) {
    for (double& count : channel) count = *next++;
  }
  return null;
}

/// None in files of older programs.
std::optional<pose::SurfaceNoise> noiseIn(const Meta& meta) {
  const auto found = meta.find("noise");
  if (found == meta.end() || found->second == kNotAsked) return std::nullopt;
  std::istringstream words(found->second);
  std::string cell, thickness, sparse;
  words >> cell >> thickness >> sparse;
  const auto cell_m = numberFrom<double>(cell), thickness_m = numberFrom<double>(thickness);
  if (!cell_m || !(*cell_m > 0) || !thickness_m || !(*thickness_m >= 0) ||
      !std::isfinite(*thickness_m) || (sparse != "0" && sparse != "1"))
    throw Damage("meta: noise has no cell size and thickness: " + found->second);
  return pose::SurfaceNoise{*cell_m, *thickness_m, sparse == "1"};
}

/// 0 in files of older programs, which stored all edges.
double edgeRadiusIn(const Meta& meta) {
  if (meta.count("edge_radius_m") == 0) return 0;
  const double radius_m = numberIn<double>(meta, "edge_radius_m");
  if (!(radius_m >= 0) || !std::isfinite(radius_m))
    throw Damage("meta: edge_radius_m is no length: " + textIn(meta, "edge_radius_m"));
  return radius_m;
}

Meta readMeta(ContentReader& in) {
  Meta meta;
  in.table<NamedRow<std::string>>(
      "meta", [&](std::int64_t, NamedRow<std::string>& row) { meta[row.name] = row.value; });
  return meta;
}

/// The single values of the parts; what they contain comes later.
void setNumbers(const Meta& meta, SemanticMap& map) {
  forEachNumber(map, [&](const char* name, double& value) {
    value = numberIn<double>(meta, name);
    if (!std::isfinite(value)) throw Damage(std::string("meta: ") + name + " is not finite");
  });
  if (map.bev.cell_m <= 0) throw Damage("meta: plan_cell_m is not positive");
  if (std::abs(map.bev.alignment.norm() - 1) > 1e-6)
    throw Damage("meta: plan_upright is no rotation");
  if (textIn(meta, "plan_channels") != channelNames())
    throw Damage("plan view with unknown channels");
  map.bev.aerial = numberIn<int>(meta, "plan_aerial") != 0;
  map.graph.space = graphSpaceIn(meta);
  map.size = sizeIn(meta);
  map.program_version = textIn(meta, "program_version");
  map.options_yaml = textIn(meta, "options");
  map.wrong_places = wrongPlacesIn(meta);
  map.own_stretches = ownStretchesIn(meta);
  map.null = pathNullIn(meta);
  map.noise = noiseIn(meta);
}

// ---- maps as a whole

/// Throws if a part of the map could not be read back as it is.
void requireStorable(const SemanticMap& map) {
  if (!isConsistent(map.graph)) throw std::invalid_argument("the graph of the map is inconsistent");
  for (std::size_t i = 0; i < map.graph.size(); ++i) {
    if (!map.graph.vertices[i].position.allFinite()) {
      throw std::invalid_argument("vertex " + std::to_string(i) +
                                  " of the map has a position that is not finite");
    }
  }
  if (map.frames.size() != map.poses.size() || map.stamps_s.size() != map.poses.size() ||
      map.source_of_pose.size() != map.poses.size())
    throw std::invalid_argument("key frames of the map without number, time or source");
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    const std::string name = "key frame " + std::to_string(i) + " of the map";
    if (!isRigid(map.poses[i].matrix()))
      throw std::invalid_argument(name + " has a pose that is no rigid motion");
    if (map.source_of_pose[i] >= map.sources.size()) {
      throw std::invalid_argument(name + " comes from source " +
                                  std::to_string(map.source_of_pose[i]) + ", but there are " +
                                  std::to_string(map.sources.size()));
    }
  }
  if (!(map.bev.cell_m > 0.02) || !(map.bev.cell_m < 1e3)) {
    throw std::invalid_argument("cells of the plan view are " + std::to_string(map.bev.cell_m) +
                                " m, expected 0.02 to 1000");
  }
}

void requireComplete(const Meta& meta, const SemanticMap& map) {
  const Counts has = countsOf(map);
  const std::pair<const char*, std::size_t> counts[] = {
      {"vertices", has.vertices},
      {"edges", storesEdges(map.graph) ? map.graph.edgeCount() : 0},
      {"keyframes", map.poses.size()},
      {"cloud_points", has.points},
      {"plan_samples", has.samples}};
  for (const auto& [name, found] : counts) {
    const auto expected = numberIn<std::size_t>(meta, name);
    if (found == expected) continue;
    throw Damage(std::string(name) + ": expected " + std::to_string(expected) + ", found " +
                 std::to_string(found));
  }
  for (const Eigen::Isometry3d& T : map.poses) {
    if (!isRigid(T.matrix())) throw Damage("key frame with a pose that is no rigid motion");
  }
  for (const std::uint32_t source : map.source_of_pose) {
    if (source >= map.sources.size()) throw Damage("key frame of an unknown source");
  }
}

LabelSet readLabels(ContentReader& in, const std::string& set_name) {
  LabelSet labels(set_name);
  in.table<ClassInfo>("labels", [&](std::int64_t id, ClassInfo& info) {
    if (id < 0 || id > 0xFFFFFFFFll) throw Damage("labels: class id out of range");
    info.id = static_cast<std::uint32_t>(id);
    labels.add(std::move(info));
  });
  return labels;
}

std::vector<VertexBlock> readVertexBlocks(ContentReader& in, std::uint64_t announced,
                                          std::uint64_t file_bytes) {
  // None has fewer bytes than one (toBlocks).
  if (announced > file_bytes)
    throw Damage("vertices: more than a map of " + std::to_string(file_bytes) + " bytes can hold");
  std::vector<VertexBlock> blocks;
  std::uint64_t found = 0;
  in.table<VertexBlock>("vertices", [&](std::int64_t id, VertexBlock& block) {
    found += block.vertices;
    if (found > announced)
      throw Damage("vertices: expected " + std::to_string(announced) + ", found more");
    block.first_vertex = id;
    blocks.push_back(std::move(block));
  });
  return blocks;
}

void unpackGraph(const std::vector<VertexBlock>& vertices, const std::vector<EdgeBlock>& edges,
                 std::uint64_t file_bytes, SemanticMap& map) {
  std::uint64_t count = 0;
  for (const VertexBlock& block : vertices) count += block.vertices;
  // Almost all vertices take more bytes than this; no more is believed before they are there.
  map.graph.vertices.reserve(std::min<std::uint64_t>(count, file_bytes / 16));
  for (const VertexBlock& block : vertices) appendVertices(block, map.graph.vertices);
  if (map.graph.edge_radius_m == 0) setEdges(edges, map.graph);
}

/// Null of a map that has none.
std::shared_ptr<search::MapOverview> readOverview(ContentReader& in, const BevGrid& grid) {
  auto overview = std::make_shared<search::MapOverview>();
  in.table<OverviewTile>("overview_tiles", [&](std::int64_t id, OverviewTile& tile) {
    appendTile(tile, *overview);
    if (id != tileId(tile)) throw Damage("overview_tiles: a tile out of place");
  });
  if (overview->tiles.empty()) return nullptr;
  if (overview->tiles.size() < search::MapOverview::kFewest ||
      !search::DistanceField::fitsColumns(grid.cell_m))
    throw Damage("overview_tiles: a map of this kind has none");
  return overview;
}

/// Whether the view can stay packed: what was counted on it need not be counted again.
bool isOfView(const search::PathNull& null, const Meta& meta) {
  const auto found = meta.find("plan_view");
  return found != meta.end() && null.poses > 0 && std::to_string(null.view) == found->second;
}

void readBulk(ContentReader& in, const Meta& meta, std::uint64_t file_bytes,
              const std::string& file, SemanticMap& map) {
  PackedRows rows(file_bytes);
  std::vector<Keyframe> keyframes;
  in.items("keyframes", keyframes);
  for (const Keyframe& k : keyframes)
    map.addKeyframe(k.T_map_sensor, k.number, k.stamp_s, k.source);
  std::vector<VertexBlock> vertices =
      readVertexBlocks(in, numberIn<std::uint64_t>(meta, "vertices"), file_bytes);
  const auto edges = numberIn<std::uint64_t>(meta, "edges");
  std::vector<EdgeBlock> blocks;
  in.table<EdgeBlock>("edges", [&](std::int64_t id, EdgeBlock& block) {
    rows.take("edges", block.edges, edges);
    block.first_vertex = id;
    blocks.push_back(std::move(block));
  });
  if (const double radius_m = edgeRadiusIn(meta); radius_m > 0) {
    if (edges > 0) throw Damage("edges of a radius are stored");
    map.graph.edge_radius_m = radius_m;
  }
  scaleLengths(1 / map.size, map.bev);  // tiles have the lengths of a town
  std::vector<Tile> tiles;
  rows.beginPart();
  in.table<Tile>("plan_tiles", [&](std::int64_t, Tile& tile) {
    rows.take("plan_tiles", tile.points, kAnyNumber);  // meta counts those with a channel only
    requirePlace(tile);
    tiles.push_back(std::move(tile));
  });
  const auto overview = readOverview(in, map.bev);
  const bool is_late = map.size == kTownScale;
  if (is_late && overview && isOfView(map.null, meta))
    map.stored_view = std::make_shared<const PackedBev>(std::move(tiles), map.bev, file,
                                                        numberIn<std::size_t>(meta, "plan_samples"),
                                                        map.null.view);
  else
    fill(std::move(tiles), map.bev);
  if (!map.stored_view && isOfView(map.null, meta)) map.null.view = search::fingerprintOf(map.bev);
  scaleLengths(map.size, map.bev);
  if (overview && !map.stored_view) overview->checksum = search::checksumOf(map.bev);
  map.overview = overview;
  if (is_late && map.graph.edge_radius_m > 0)
    map.stored_vertices = std::make_shared<const StoredBlocks>(std::move(vertices), file);
  else
    unpackGraph(vertices, blocks, file_bytes, map);
  const auto points = numberIn<std::uint64_t>(meta, "cloud_points");
  tiles.clear();
  rows.beginPart();
  in.table<Tile>("cloud_tiles", [&](std::int64_t id, Tile& tile) {
    rows.take("cloud_points", tile.points, points);
    requirePlace(tile);
    if (id != tileId(tile)) throw Damage("cloud_tiles: a tile out of place");
    tiles.push_back(std::move(tile));
  });
  if (!tiles.empty())
    map.stored_points = std::make_shared<const PackedCloud>(std::move(tiles), file);
  if (map.size != kTownScale) unpackPoints(map);
}

}  // namespace

void writeContent(SQLite::Database& database, const std::string& schema, const SemanticMap& map) {
  requireStorable(map);
  // Tiles have the lengths of a town, for whose precision they are made.
  const PackedBev* packed_bev = packedBevOf(map);
  const Scaled<BevGrid> bev(packed_bev ? map.bev : viewOf(map), 1 / map.size);
  const std::vector<Tile> bev_tiles = packed_bev ? packed_bev->tiles() : toTiles(*bev);
  const std::shared_ptr<const search::MapOverview> overview =
      map.stored_view || hasOverview(map) ? map.overview : search::overviewOfLarge(*bev);
  std::vector<Tile> cloud_tiles = toTiles(*Scaled<LabelledCloud>(map.cloud, 1 / map.size));
  if (const PackedCloud* packed = packedCloudOf(map)) mergeTiles(packed->tiles(), cloud_tiles);
  std::size_t stored_points = 0;
  for (const Tile& tile : cloud_tiles) stored_points += tile.points;
  std::vector<NamedRow<std::string>> meta;
  for (const auto& [name, value] : metaOf(map, stored_points)) meta.push_back({name, value});
  std::vector<ClassInfo> labels;
  for (const auto& [id, info] : map.labels.classes()) labels.push_back(info);
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < map.poses.size(); ++i)
    keyframes.push_back({map.frames[i], map.stamps_s[i], map.source_of_pose[i], map.poses[i]});

  ContentWriter out(database, schema);
  out.table("meta", meta);
  out.table("labels", labels, [](const ClassInfo& info, std::size_t) { return info.id; });
  out.table("sources", map.sources);
  out.table("keyframes", keyframes);
  const StoredBlocks* stored = storedBlocksOf(map);
  const auto known = [&](std::size_t first, std::size_t count) {
    return map.packed_vertices ? map.packed_vertices->find(map.graph.vertices, first, count)
                               : nullptr;
  };
  out.table("vertices", stored ? stored->blocks() : toBlocks(map.graph.vertices, known),
            [](const VertexBlock& b, std::size_t) { return b.first_vertex; });
  out.table("edges", storesEdges(map.graph) ? toBlocks(map.graph) : std::vector<EdgeBlock>(),
            [](const EdgeBlock& b, std::size_t) { return b.first_vertex; });
  const auto id = [](const Tile& tile, std::size_t) { return tileId(tile); };
  out.table("plan_tiles", bev_tiles, id);
  out.table("overview_tiles", overview ? toTiles(*overview) : std::vector<OverviewTile>(),
            [](const OverviewTile& tile, std::size_t) { return tileId(tile); });
  out.table("cloud_tiles", cloud_tiles, id);
  out.finish();
}

SemanticMap readContent(SQLite::Database& database) {
  checkMapTables(database);
  ContentReader in(database);
  const Meta meta = readMeta(in);
  SemanticMap map;
  map.labels = readLabels(in, textIn(meta, "label_set"));
  in.items("sources", map.sources);
  setNumbers(meta, map);
  const std::int64_t file_bytes = database.execAndGet("PRAGMA page_count").getInt64() *
                                  database.execAndGet("PRAGMA page_size").getInt64();
  const std::string file = database.getFilename();  // a visit is one of another database
  readBulk(in, meta, static_cast<std::uint64_t>(file_bytes), file == ":memory:" ? "" : file, map);
  requireComplete(meta, map);
  map.checksum = in.checksum();
  return map;
}

}  // namespace xview::map
