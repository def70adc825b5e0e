// SPDX-License-Identifier: BSD-3-Clause
#include "map_content.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <stdexcept>
#include <tuple>

#include "cloud_tiles.h"
#include "damage.h"
#include "edge_blocks.h"
#include "grid.h"
#include "map_schema.h"
#include "plan_tiles.h"
#include "table_rows.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

// ---- columns of the tables, for both directions
// -------------------------------------------------------------------------

template <class Row>
void columns(Row& row, Vertex& v) {
  row(v.label);
  row(v.instance);
  for (int i = 0; i < 3; ++i) row(v.position[i]);
  for (int i = 0; i < 3; ++i) row(v.extent[i]);
  row(v.sigma_m);
  row(v.observations);
  row(v.points);
  row(v.first_frame);
  row(v.last_frame);
}

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
void columns(Row& row, PlanTile& t) {
  row(t.x);
  row(t.y);
  row(t.known);
  row(t.samples);
  row(t.data);
}

template <class Row>
void columns(Row& row, CloudTile& t) {
  row(t.x);
  row(t.y);
  row(t.z);
  row(t.points);
  row(t.data);
}

template <class Row>
void columns(Row& row, EdgeBlock& b) {
  row(b.edges);
  row(b.data);
}

// ---- small values as text
// -----------------------------------------------------------------------------------------------

using Meta = std::map<std::string, std::string>;

template <class Number>
std::string textOf(Number value) {
  char text[64];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

const std::string& textIn(const Meta& meta, const std::string& name) {
  const auto found = meta.find(name);
  if (found == meta.end()) throw Damage("meta: no " + name);
  return found->second;
}

template <class Number>
Number numberIn(const Meta& meta, const std::string& name) {
  const std::string& text = textIn(meta, name);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw Damage("meta: " + name + " is no number: " + text);
  return value;
}

double finiteIn(const Meta& meta, const std::string& name) {
  const double value = numberIn<double>(meta, name);
  if (!std::isfinite(value)) throw Damage("meta: " + name + " is not finite");
  return value;
}

Meta metaOf(const SemanticMap& map, std::size_t stored_points) {
  return {{"program_version", XVIEW_VERSION},
          {"label_set", map.labels.name()},
          {"options", map.options_yaml},
          {"vertices", textOf(map.graph.size())},
          {"edges", textOf(map.graph.edgeCount())},
          {"keyframes", textOf(map.keyframes.size())},
          {"cloud_points", textOf(stored_points)},
          {"cloud_instances", textOf(map.cloud.instances.empty() ? 0 : 1)},
          {"cloud_origin_x", textOf(map.cloud.origin.x())},
          {"cloud_origin_y", textOf(map.cloud.origin.y())},
          {"cloud_origin_z", textOf(map.cloud.origin.z())},
          {"plan_samples", textOf(map.plan.sampleCount())},
          {"plan_channels", channelNames()},
          {"plan_cell_m", textOf(map.plan.cell_m)},
          {"plan_origin_x", textOf(map.plan.origin_x)},
          {"plan_origin_y", textOf(map.plan.origin_y)},
          {"plan_origin_z", textOf(map.plan.origin_z)},
          {"plan_aerial", textOf(map.plan.aerial ? 1 : 0)},
          {"plan_upright_w", textOf(map.plan.upright.w())},
          {"plan_upright_x", textOf(map.plan.upright.x())},
          {"plan_upright_y", textOf(map.plan.upright.y())},
          {"plan_upright_z", textOf(map.plan.upright.z())}};
}

Role roleOf(const std::string& text) {
  for (const Role role : {Role::object, Role::surface, Role::dynamic, Role::ignored}) {
    if (text == toString(role)) return role;
  }
  throw Damage("labels: unknown role " + text);
}

Kind kindOf(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(Kind::none); ++i) {
    if (text == toString(static_cast<Kind>(i))) return static_cast<Kind>(i);
  }
  throw Damage("labels: unknown kind " + text);
}

// ---- writing
// ------------------------------------------------------------------------------------------------------------

/// Throws if a part of the map could not be read back as it is.
void requireStorable(const SemanticMap& map) {
  if (!isConsistent(map.graph)) throw std::invalid_argument("the graph of the map is inconsistent");
  for (std::size_t i = 0; i < map.graph.size(); ++i) {
    if (!map.graph.vertices[i].position.allFinite()) {
      throw std::invalid_argument("vertex " + std::to_string(i) +
                                  " of the map has a position that is not finite");
    }
  }
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    if (!isRigid(map.keyframes[i].T_map_sensor.matrix())) {
      throw std::invalid_argument("key frame " + std::to_string(i) +
                                  " of the map has a pose that is no rigid motion");
    }
    if (map.keyframes[i].source >= map.sources.size()) {
      throw std::invalid_argument("key frame " + std::to_string(i) +
                                  " of the map comes from source " +
                                  std::to_string(map.keyframes[i].source) + ", but there are " +
                                  std::to_string(map.sources.size()));
    }
  }
  if (!map.cloud.instances.empty() && map.cloud.instances.size() != map.cloud.size()) {
    throw std::invalid_argument("the cloud of the map has " + std::to_string(map.cloud.size()) +
                                " points but " + std::to_string(map.cloud.instances.size()) +
                                " instances");
  }
  if (!(map.plan.cell_m > 0.01) || !(map.plan.cell_m < 1e3)) {
    throw std::invalid_argument("cells of the plan view are " + std::to_string(map.plan.cell_m) +
                                " m, expected 0.01 to 1000");
  }
}

/// Writes the tables one after the other and the hash of each at the end.
class ContentWriter {
 public:
  ContentWriter(SQLite::Database& database, std::string schema)
      : database_(database), schema_(std::move(schema)) {}

  /// fill(writer) writes all rows.
  template <class Fill>
  void table(const std::string& name, Fill&& fill) {
    RowWriter row(database_, schema_ + "." + name, mapTable(name).columns);
    fill(row);
    hashes_.emplace_back(name, row.hash());
  }

  /// One row per item; id(item, index) gives its key.
  template <class Item, class Id>
  void items(const std::string& name, const std::vector<Item>& all, Id&& id) {
    table(name, [&](RowWriter& row) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        row(static_cast<std::int64_t>(id(all[i], i)));
        Item copy = all[i];
        columns(row, copy);
        row.endRow();
      }
    });
  }

  void finish() {
    RowWriter row(database_, schema_ + ".checksums", mapTable("checksums").columns);
    int id = 0;
    for (const auto& [name, hash] : hashes_) {
      row(id++);
      row(name);
      row(hash);
      row.endRow();
    }
  }

 private:
  SQLite::Database& database_;
  std::string schema_;
  std::vector<std::pair<std::string, std::int64_t>> hashes_;
};

void writeMeta(ContentWriter& out, const Meta& meta) {
  out.table("meta", [&](RowWriter& row) {
    int id = 0;
    for (const auto& [name, value] : meta) {
      row(id++);
      row(name);
      row(value);
      row.endRow();
    }
  });
}

void writeLabels(ContentWriter& out, const LabelSet& labels) {
  out.table("labels", [&](RowWriter& row) {
    for (const auto& [id, info] : labels.classes()) {
      row(id);
      row(info.name);
      for (const std::uint8_t c : info.color) row(c);
      row(std::string(toString(info.role)));
      row(std::string(toString(info.kind)));
      row(info.guessed);
      row.endRow();
    }
  });
}

void writeSources(ContentWriter& out, const std::vector<std::string>& sources) {
  out.table("sources", [&](RowWriter& row) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
      row(i);
      row(sources[i]);
      row.endRow();
    }
  });
}

// ---- reading
// ------------------------------------------------------------------------------------------------------------

class ContentReader {
 public:
  explicit ContentReader(SQLite::Database& database) : database_(database) {
    RowReader row(database_, "checksums");
    while (row.nextRow()) {
      std::int64_t id = 0, hash = 0;
      std::string name;
      row(id);
      row(name);
      row(hash);
      hashes_[name] = hash;
    }
  }

  /// take(row, id) reads the columns behind the id of each row.
  template <class Take>
  void table(const std::string& name, Take&& take) {
    RowReader row(database_, name);
    while (row.nextRow()) {
      std::int64_t id = 0;
      row(id);
      take(row, id);
    }
    const auto hash = hashes_.find(name);
    if (hash == hashes_.end()) throw Damage("no checksum of table " + name);
    row.verify(hash->second);
  }

 private:
  SQLite::Database& database_;
  std::map<std::string, std::int64_t> hashes_;
};

Meta readMeta(ContentReader& in) {
  Meta meta;
  in.table("meta", [&](RowReader& row, std::int64_t) {
    std::string name, value;
    row(name);
    row(value);
    meta[name] = value;
  });
  return meta;
}

LabelSet readLabels(ContentReader& in, const std::string& set_name) {
  LabelSet labels(set_name);
  in.table("labels", [&](RowReader& row, std::int64_t id) {
    ClassInfo info;
    std::string role, kind;
    if (id < 0 || id > 0xFFFFFFFFll) throw Damage("labels: class id out of range");
    info.id = static_cast<std::uint32_t>(id);
    row(info.name);
    for (std::uint8_t& c : info.color) row(c);
    row(role);
    row(kind);
    row(info.guessed);
    info.role = roleOf(role);
    info.kind = kindOf(kind);
    labels.add(std::move(info));
  });
  return labels;
}

std::vector<std::string> readSources(ContentReader& in) {
  std::vector<std::string> sources;
  in.table("sources", [&](RowReader& row, std::int64_t) { row(sources.emplace_back()); });
  return sources;
}

/// Rows whose ids count from zero.
template <class Item>
std::vector<Item> readItems(ContentReader& in, const std::string& name) {
  std::vector<Item> items;
  in.table(name, [&](RowReader& row, std::int64_t id) {
    if (id != static_cast<std::int64_t>(items.size()))
      throw Damage("table " + name + " misses a row");
    columns(row, items.emplace_back());
  });
  return items;
}

void readEdges(ContentReader& in, SemanticGraph& graph) {
  std::vector<EdgeBlock> blocks;
  in.table("edges", [&](RowReader& row, std::int64_t id) {
    EdgeBlock& block = blocks.emplace_back();
    block.first_vertex = id;
    columns(row, block);
  });
  setEdges(blocks, graph);
}

PlanView readPlan(ContentReader& in, const Meta& meta) {
  PlanView plan;
  plan.cell_m = finiteIn(meta, "plan_cell_m");
  if (plan.cell_m <= 0) throw Damage("meta: plan_cell_m is not positive");
  plan.origin_x = finiteIn(meta, "plan_origin_x");
  plan.origin_y = finiteIn(meta, "plan_origin_y");
  plan.origin_z = finiteIn(meta, "plan_origin_z");
  plan.aerial = numberIn<int>(meta, "plan_aerial") != 0;
  plan.upright = Eigen::Quaterniond(finiteIn(meta, "plan_upright_w"), finiteIn(meta, "plan_upright_x"),
                                    finiteIn(meta, "plan_upright_y"), finiteIn(meta, "plan_upright_z"));
  if (std::abs(plan.upright.norm() - 1) > 1e-6) throw Damage("meta: plan_upright is no rotation");
  if (textIn(meta, "plan_channels") != channelNames())
    throw Damage("plan view with unknown channels");
  in.table("plan_tiles", [&](RowReader& row, std::int64_t) {
    PlanTile tile;
    columns(row, tile);
    appendTile(tile, plan);
  });
  std::sort(plan.known.begin(), plan.known.end(), [](const GroundCell& a, const GroundCell& b) {
    return std::tie(a.y, a.x) < std::tie(b.y, b.x);
  });
  return plan;
}

LabelledCloud readCloud(ContentReader& in, const Meta& meta) {
  LabelledCloud cloud;
  for (int i = 0; i < 3; ++i)
    cloud.origin[i] = finiteIn(meta, std::string("cloud_origin_") + "xyz"[i]);
  in.table("cloud_tiles", [&](RowReader& row, std::int64_t) {
    CloudTile tile;
    columns(row, tile);
    appendTile(tile, cloud);
  });
  cloud.points.width = static_cast<std::uint32_t>(cloud.points.size());
  cloud.points.height = 1;
  if (numberIn<int>(meta, "cloud_instances") == 0) cloud.instances.clear();
  return cloud;
}

void requireCount(const Meta& meta, const std::string& name, std::size_t found) {
  const auto expected = numberIn<std::size_t>(meta, name);
  if (found != expected) {
    throw Damage(name + ": expected " + std::to_string(expected) + ", found " +
                 std::to_string(found));
  }
}

void requireComplete(const Meta& meta, const SemanticMap& map) {
  requireCount(meta, "vertices", map.graph.size());
  requireCount(meta, "edges", map.graph.edgeCount());
  requireCount(meta, "keyframes", map.keyframes.size());
  requireCount(meta, "cloud_points", map.cloud.size());
  requireCount(meta, "plan_samples", map.plan.sampleCount());
  for (const Vertex& v : map.graph.vertices) {
    if (!v.position.allFinite()) throw Damage("vertex with a position that is not finite");
  }
  for (const Keyframe& k : map.keyframes) {
    if (!isRigid(k.T_map_sensor.matrix()))
      throw Damage("key frame with a pose that is no rigid motion");
    if (k.source >= map.sources.size()) throw Damage("key frame of an unknown source");
  }
}

}  // namespace

void writeContent(SQLite::Database& database, const std::string& schema, const SemanticMap& map) {
  requireStorable(map);
  const std::vector<PlanTile> plan_tiles = toTiles(map.plan);
  const std::vector<CloudTile> cloud_tiles = toTiles(map.cloud);
  std::size_t stored_points = 0;
  for (const CloudTile& tile : cloud_tiles) stored_points += tile.points;

  ContentWriter out(database, schema);
  writeMeta(out, metaOf(map, stored_points));
  writeLabels(out, map.labels);
  writeSources(out, map.sources);
  const auto position = [](const auto&, std::size_t i) { return i; };
  out.items("keyframes", map.keyframes, position);
  out.items("vertices", map.graph.vertices, position);
  out.items("edges", toBlocks(map.graph),
            [](const EdgeBlock& b, std::size_t) { return b.first_vertex; });
  out.items("plan_tiles", plan_tiles,
            [](const PlanTile& t, std::size_t) { return tileId(t.x, t.y, 0); });
  out.items("cloud_tiles", cloud_tiles,
            [](const CloudTile& t, std::size_t) { return tileId(t.x, t.y, t.z); });
  out.finish();
}

SemanticMap readContent(SQLite::Database& database) {
  checkMapTables(database);
  ContentReader in(database);
  const Meta meta = readMeta(in);
  SemanticMap map;
  map.labels = readLabels(in, textIn(meta, "label_set"));
  map.sources = readSources(in);
  map.options_yaml = textIn(meta, "options");
  map.keyframes = readItems<Keyframe>(in, "keyframes");
  map.graph.vertices = readItems<Vertex>(in, "vertices");
  readEdges(in, map.graph);
  map.plan = readPlan(in, meta);
  map.cloud = readCloud(in, meta);
  requireComplete(meta, map);
  return map;
}

MapSummary readSummary(SQLite::Database& database) {
  checkMapTables(database);
  ContentReader in(database);
  const Meta meta = readMeta(in);
  MapSummary summary;
  summary.schema_version = kMapSchemaVersion;
  summary.program_version = textIn(meta, "program_version");
  summary.label_set = textIn(meta, "label_set");
  summary.vertices = numberIn<std::size_t>(meta, "vertices");
  summary.edges = numberIn<std::size_t>(meta, "edges");
  summary.keyframes = numberIn<std::size_t>(meta, "keyframes");
  summary.cloud_points = numberIn<std::size_t>(meta, "cloud_points");
  summary.plan_samples = numberIn<std::size_t>(meta, "plan_samples");
  summary.sources = readSources(in);
  return summary;
}

}  // namespace xview
