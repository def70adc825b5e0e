// SPDX-License-Identifier: BSD-3-Clause
#include "map_schema.h"

#include <SQLiteCpp/Statement.h>

#include "damage.h"

namespace xview {

const std::array<MapTable, 9> kMapTables = {{
    {"meta", 3,
     "\n  id INTEGER PRIMARY KEY,\n  name TEXT,   -- origins in metres: p_map = origin + p\n  "
     "value TEXT\n"},
    {"labels", 8,
     "\n  id INTEGER PRIMARY KEY, -- class id\n  name TEXT,\n  red INTEGER, green INTEGER, blue "
     "INTEGER,\n"
     "  role TEXT,              -- object, surface, dynamic, ignored\n"
     "  kind TEXT,\n  guessed INTEGER         -- 1: role derived from the name\n  reserved "
     "INTEGER\n"},
    {"sources", 2, "\n  id INTEGER PRIMARY KEY, -- in order of arrival\n  path TEXT\n"},
    {"keyframes", 16,
     "\n  id INTEGER PRIMARY KEY,\n  number INTEGER,         -- of the frame in its source\n  "
     "stamp_s REAL,\n"
     "  source INTEGER,         -- sources.id\n"
     "  r00 REAL, r01 REAL, r02 REAL, x REAL, -- T_map_sensor, row by row, metres\n"
     "  r10 REAL, r11 REAL, r12 REAL, y REAL,\n  r20 REAL, r21 REAL, r22 REAL, z REAL\n"},
    {"vertices", 14,
     "\n  id INTEGER PRIMARY KEY,\n  label INTEGER,          -- labels.id\n  instance INTEGER,     "
     "  -- 0: none\n"
     "  x REAL, y REAL, z REAL, -- map frame, metres\n"
     "  extent_x REAL, extent_y REAL, extent_z REAL,\n  sigma_m REAL,\n  observations INTEGER,\n"
     "  points INTEGER,\n  first_frame INTEGER,\n  last_frame INTEGER\n"},
    {"edges", 3,
     "\n  id INTEGER PRIMARY KEY, -- vertices.id of the first of 4096 vertices\n"
     "  edges INTEGER,          -- from these to later vertices\n  data BLOB               -- "
     "packed\n"},
    {"plan_tiles", 6,
     "\n  id INTEGER PRIMARY KEY,\n  x INTEGER, y INTEGER,   -- tile of 64 x 64 cells: floor(cell "
     "index / 64)\n"
     "  known INTEGER,          -- cells seen\n  samples INTEGER,\n"
     "  data BLOB               -- packed, 1 cm\n"},
    {"cloud_tiles", 6,
     "\n  id INTEGER PRIMARY KEY,\n  x INTEGER, y INTEGER, z INTEGER, -- tile of 64 m from the "
     "origin of the cloud\n"
     "  points INTEGER,\n  data BLOB               -- packed, 1 cm\n"},
    {"checksums", 3,
     "\n  id INTEGER PRIMARY KEY,\n  table_name TEXT,\n  content INTEGER         -- hash of all "
     "values\n"},
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
