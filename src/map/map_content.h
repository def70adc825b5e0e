// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <SQLiteCpp/Database.h>

#include <string>

#include "xview/map/map_store.h"
#include "xview/map/semantic_map.h"

namespace xview {

/// Fills the empty tables of a schema ("main", or an attached one). Throws std::logic_error if
/// the map cannot be written as it is.
void writeContent(SQLite::Database& database, const std::string& schema, const SemanticMap& map);

/// Reads the tables of "main"; throws Damage.
SemanticMap readContent(SQLite::Database& database);

/// Only the small tables.
MapSummary readSummary(SQLite::Database& database);

}  // namespace xview
