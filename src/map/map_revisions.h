// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <SQLiteCpp/Database.h>

#include <string>
#include <vector>

namespace xview {

// All of these run inside a transaction of the caller.

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

}  // namespace xview
