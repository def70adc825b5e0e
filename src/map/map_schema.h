// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <SQLiteCpp/Database.h>

#include <array>
#include <cstdint>
#include <string>

namespace xview {

constexpr std::uint32_t kMapApplicationId = 0x78766D70;  // "xvmp"
constexpr int kMapSchemaVersion = 1;

struct MapTable {
  const char* name;
  int columns;
  const char* definition;  ///< what stands between the brackets of CREATE TABLE; comments show in
                           ///< `sqlite3 FILE .schema`
};

/// All tables with content, each with an integer primary key `id`; `checksums` is the last and
/// covers the others.
extern const std::array<MapTable, 9> kMapTables;

const MapTable& mapTable(const std::string& name);

/// Creates the empty tables in a schema of the connection ("main", or an attached one).
void createMapTables(SQLite::Database& database, const std::string& schema);

/// Throws Damage if a table is missing or defined otherwise, or if the file has triggers or views,
/// which we never write.
void checkMapTables(SQLite::Database& database);

}  // namespace xview
