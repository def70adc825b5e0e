// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <SQLiteCpp/Database.h>

#include <string>
#include <vector>

#include "xview/map/map_store.h"

namespace xview::map {

/// Fills the empty tables of a schema ("main", or an attached one). Throws std::logic_error if
/// the map cannot be written as it is.
void writeContent(SQLite::Database& database, const std::string& schema, const SemanticMap& map);

/// Reads the tables of "main"; throws Damage.
SemanticMap readContent(SQLite::Database& database);

/// Only the small tables, and the notes of the revisions.
MapSummary readSummary(SQLite::Database& database);

// Revisions. All of these run inside a transaction of the caller.

/// Makes the tables of "main" equal to those of the attached schema "fresh"; rows that do not
/// differ are not touched.
void takeOverFresh(SQLite::Database& database);

/// Notes which rows takeOverFresh is going to change.
void recordRevision(SQLite::Database& database, const std::string& note);

/// Restores the rows before the last recorded revision and forgets it; false if there is none.
bool restoreRevision(SQLite::Database& database);

void forgetRevisions(SQLite::Database& database);

/// Oldest first.
std::vector<std::string> revisionNotes(SQLite::Database& database);

}  // namespace xview::map
