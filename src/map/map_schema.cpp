// SPDX-License-Identifier: BSD-3-Clause
#include "map_schema.h"

#include <SQLiteCpp/Statement.h>

#include "damage.h"

namespace xview {

const std::array<MapTable, 9> kMapTables = {{
    {"meta", 3, R"(
  id INTEGER PRIMARY KEY,
  name TEXT,              -- origins in metres: p_map = origin + p
  value TEXT
)"},
    {"labels", 8, R"(
  id INTEGER PRIMARY KEY, -- class id
  name TEXT,
  red INTEGER, green INTEGER, blue INTEGER,
  role TEXT,              -- object, surface, dynamic, ignored
  kind TEXT,
  guessed INTEGER         -- 1: role derived from the name
)"},
    {"sources", 2, R"(
  id INTEGER PRIMARY KEY, -- in order of arrival
  path TEXT
)"},
    {"keyframes", 16, R"(
  id INTEGER PRIMARY KEY,
  number INTEGER,         -- of the frame in its source
  stamp_s REAL,
  source INTEGER,         -- sources.id
  r00 REAL, r01 REAL, r02 REAL, x REAL, -- T_map_sensor, row by row, metres
  r10 REAL, r11 REAL, r12 REAL, y REAL,
  r20 REAL, r21 REAL, r22 REAL, z REAL
)"},
    {"vertices", 14, R"(
  id INTEGER PRIMARY KEY,
  label INTEGER,          -- labels.id
  instance INTEGER,       -- 0: none
  x REAL, y REAL, z REAL, -- map frame, metres
  extent_x REAL, extent_y REAL, extent_z REAL,
  sigma_m REAL,
  observations INTEGER,
  points INTEGER,
  first_frame INTEGER,
  last_frame INTEGER
)"},
    {"edges", 3, R"(
  id INTEGER PRIMARY KEY, -- vertices.id of the first of 4096 vertices
  edges INTEGER,          -- from these to later vertices
  data BLOB               -- packed
)"},
    {"plan_tiles", 6, R"(
  id INTEGER PRIMARY KEY,
  x INTEGER, y INTEGER,   -- tile of 64 x 64 cells: floor(cell index / 64)
  known INTEGER,          -- cells seen
  samples INTEGER,
  data BLOB               -- packed, 1 cm
)"},
    {"cloud_tiles", 6, R"(
  id INTEGER PRIMARY KEY,
  x INTEGER, y INTEGER, z INTEGER, -- tile of 64 m from the origin of the cloud
  points INTEGER,
  data BLOB               -- packed, 1 cm
)"},
    {"checksums", 3, R"(
  id INTEGER PRIMARY KEY,
  table_name TEXT,
  content INTEGER         -- hash of all values
)"},
}};

namespace {

std::string definitionOf(const MapTable& table) {
  return "CREATE TABLE " + std::string(table.name) + "(" + table.definition + ")";
}

void checkTable(SQLite::Database& database, const MapTable& table) {
  SQLite::Statement query(database,
                          "SELECT sql FROM sqlite_master WHERE type = 'table' AND name = ?");
  query.bind(1, table.name);
  if (!query.executeStep()) throw Damage("table " + std::string(table.name) + " is missing");
  if (query.getColumn(0).getString() != definitionOf(table)) {
    throw Damage("table " + std::string(table.name) + " has other columns than expected");
  }
}

}  // namespace

const MapTable& mapTable(const std::string& name) {
  for (const MapTable& table : kMapTables) {
    if (name == table.name) return table;
  }
  throw std::logic_error("no table " + name + " in a map file");
}

void createMapTables(SQLite::Database& database, const std::string& schema) {
  for (const MapTable& table : kMapTables) {
    database.exec("CREATE TABLE " + schema + "." + table.name + "(" + table.definition + ")");
  }
}

void checkMapTables(SQLite::Database& database) {
  for (const MapTable& table : kMapTables) checkTable(database, table);
  SQLite::Statement others(database,
                           "SELECT name FROM sqlite_master WHERE type NOT IN ('table', 'index')");
  if (others.executeStep()) throw Damage("unexpected object " + others.getColumn(0).getString());
}

}  // namespace xview
