// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <tuple>

#include "damage.h"
#include "map_columns.h"
#include "map_content.h"
#include "map_meta.h"
#include "map_schema.h"
#include "table_rows.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

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

/// Maps of the first days do not say it: they are of the cloud.
GraphSpace graphSpaceIn(const Meta& meta) {
  const auto found = meta.find("graph_space");
  if (found == meta.end()) return GraphSpace::cloud;
  for (const GraphSpace space : {GraphSpace::cloud, GraphSpace::image}) {
    if (found->second == toString(space)) return space;
  }
  throw Damage("meta: unknown graph_space " + found->second);
}

PlanView readPlan(ContentReader& in, const Meta& meta) {
  PlanView plan;
  plan.cell_m = finiteIn(meta, "plan_cell_m");
  if (plan.cell_m <= 0) throw Damage("meta: plan_cell_m is not positive");
  plan.origin_x = finiteIn(meta, "plan_origin_x");
  plan.origin_y = finiteIn(meta, "plan_origin_y");
  plan.origin_z = finiteIn(meta, "plan_origin_z");
  plan.aerial = numberIn<int>(meta, "plan_aerial") != 0;
  plan.upright =
      Eigen::Quaterniond(finiteIn(meta, "plan_upright_w"), finiteIn(meta, "plan_upright_x"),
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
  return cloud;
}

void requireComplete(const Meta& meta, const SemanticMap& map) {
  requireCount(meta, "vertices", map.graph.size());
  requireCount(meta, "edges", map.graph.edgeCount());
  requireCount(meta, "keyframes", map.poses.size());
  requireCount(meta, "cloud_points", map.cloud.size());
  requireCount(meta, "plan_samples", map.plan.sampleCount());
  for (const Vertex& v : map.graph.vertices) {
    if (!v.position.allFinite()) throw Damage("vertex with a position that is not finite");
  }
  for (const Eigen::Isometry3d& T : map.poses) {
    if (!isRigid(T.matrix())) throw Damage("key frame with a pose that is no rigid motion");
  }
  for (const std::uint32_t source : map.source_of_pose) {
    if (source >= map.sources.size()) throw Damage("key frame of an unknown source");
  }
}

}  // namespace

SemanticMap readContent(SQLite::Database& database) {
  checkMapTables(database);
  ContentReader in(database);
  const Meta meta = readMeta(in);
  SemanticMap map;
  map.labels = readLabels(in, textIn(meta, "label_set"));
  map.sources = readSources(in);
  map.options_yaml = textIn(meta, "options");
  for (const Keyframe& k : readItems<Keyframe>(in, "keyframes"))
    map.addKeyframe(k.T_map_sensor, k.number, k.stamp_s, k.source);
  map.graph.vertices = readItems<Vertex>(in, "vertices");
  readEdges(in, map.graph);
  map.graph.space = graphSpaceIn(meta);
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
