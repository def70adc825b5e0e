// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "grid.h"
#include "map_columns.h"
#include "map_content.h"
#include "map_meta.h"
#include "map_schema.h"
#include "table_rows.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

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
    if (!isRigid(map.poses[i].matrix())) {
      throw std::invalid_argument("key frame " + std::to_string(i) +
                                  " of the map has a pose that is no rigid motion");
    }
    if (map.source_of_pose[i] >= map.sources.size()) {
      throw std::invalid_argument("key frame " + std::to_string(i) +
                                  " of the map comes from source " +
                                  std::to_string(map.source_of_pose[i]) + ", but there are " +
                                  std::to_string(map.sources.size()));
    }
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

std::vector<Keyframe> keyframesOf(const SemanticMap& map) {
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < map.poses.size(); ++i)
    keyframes.push_back({map.frames[i], map.stamps_s[i], map.source_of_pose[i], map.poses[i]});
  return keyframes;
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
  out.items("keyframes", keyframesOf(map), position);
  out.items("vertices", map.graph.vertices, position);
  out.items("edges", toBlocks(map.graph),
            [](const EdgeBlock& b, std::size_t) { return b.first_vertex; });
  out.items("plan_tiles", plan_tiles,
            [](const PlanTile& t, std::size_t) { return tileId(t.x, t.y, 0); });
  out.items("cloud_tiles", cloud_tiles,
            [](const CloudTile& t, std::size_t) { return tileId(t.x, t.y, t.z); });
  out.finish();
}

}  // namespace xview
