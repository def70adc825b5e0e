// SPDX-License-Identifier: BSD-3-Clause
// Table undo_steps lists the revisions; undo_added the keys of rows that a revision wrote; and
// undo_<table> the rows that it removed or overwrote. They exist only in files that have a
// revision.
#include "map_revisions.h"

#include <SQLiteCpp/Statement.h>

#include "map_schema.h"

namespace xview {
namespace {

bool hasRevisions(SQLite::Database& database) { return database.tableExists("undo_steps"); }

void createRevisionTables(SQLite::Database& database) {
  if (hasRevisions(database)) return;
  database.exec("CREATE TABLE undo_steps(step INTEGER PRIMARY KEY, note TEXT)");
  database.exec("CREATE TABLE undo_added(step INTEGER, table_name TEXT, id INTEGER)");
  for (const MapTable& table : kMapTables) {
    const std::string name = table.name;
    database.exec("CREATE TABLE undo_" + name + " AS SELECT 0 AS step, * FROM main." + name +
                  " WHERE 0");
  }
}

/// Rows of one schema that the other does not have in the same form.
std::string rowsOnlyIn(const std::string& schema, const std::string& other,
                       const std::string& table) {
  return "SELECT * FROM " + schema + "." + table + " EXCEPT SELECT * FROM " + other + "." + table;
}

void execute(SQLite::Database& database, const std::string& sql, int step) {
  SQLite::Statement statement(database, sql);
  statement.bind(1, step);
  statement.exec();
}

int lastStep(SQLite::Database& database) {
  return database.execAndGet("SELECT coalesce(max(step), 0) FROM undo_steps").getInt();
}

/// "id, name, value": the columns of a table without the step in front.
std::string columnsOf(SQLite::Database& database, const std::string& table) {
  std::string columns;
  SQLite::Statement query(database, "SELECT name FROM pragma_table_info(?)");
  query.bind(1, table);
  while (query.executeStep())
    columns += (columns.empty() ? "" : ", ") + query.getColumn(0).getString();
  return columns;
}

}  // namespace

void takeOverFresh(SQLite::Database& database) {
  for (const MapTable& table : kMapTables) {
    const std::string name = table.name;
    database.exec("DELETE FROM main." + name + " WHERE id IN (SELECT id FROM (" +
                  rowsOnlyIn("main", "fresh", name) + "))");
    database.exec("INSERT INTO main." + name + " SELECT * FROM fresh." + name +
                  " WHERE id NOT IN (SELECT id FROM main." + name + ") ORDER BY id");
  }
}

void recordRevision(SQLite::Database& database, const std::string& note) {
  createRevisionTables(database);
  const int step = lastStep(database) + 1;
  SQLite::Statement insert(database, "INSERT INTO undo_steps VALUES(?, ?)");
  insert.bind(1, step);
  insert.bind(2, note);
  insert.exec();
  for (const MapTable& table : kMapTables) {
    const std::string name = table.name;
    execute(database,
            "INSERT INTO undo_" + name + " SELECT ?, * FROM (" + rowsOnlyIn("main", "fresh", name) +
                ")",
            step);
    execute(database,
            "INSERT INTO undo_added SELECT ?, '" + name + "', id FROM (" +
                rowsOnlyIn("fresh", "main", name) + ")",
            step);
  }
}

bool restoreRevision(SQLite::Database& database) {
  if (!hasRevisions(database)) return false;
  const int step = lastStep(database);
  if (step == 0) return false;
  for (const MapTable& table : kMapTables) {
    const std::string name = table.name;
    execute(database,
            "DELETE FROM " + name +
                " WHERE id IN (SELECT id FROM undo_added WHERE step = ? AND table_name = '" + name +
                "')",
            step);
    execute(database,
            "INSERT INTO " + name + " SELECT " + columnsOf(database, name) + " FROM undo_" + name +
                " WHERE step = ? ORDER BY id",
            step);
    execute(database, "DELETE FROM undo_" + name + " WHERE step = ?", step);
  }
  execute(database, "DELETE FROM undo_added WHERE step = ?", step);
  execute(database, "DELETE FROM undo_steps WHERE step = ?", step);
  if (step == 1) forgetRevisions(database);
  return true;
}

void forgetRevisions(SQLite::Database& database) {
  database.exec("DROP TABLE IF EXISTS undo_steps");
  database.exec("DROP TABLE IF EXISTS undo_added");
  for (const MapTable& table : kMapTables)
    database.exec("DROP TABLE IF EXISTS undo_" + std::string(table.name));
}

std::vector<std::string> revisionNotes(SQLite::Database& database) {
  std::vector<std::string> notes;
  if (!hasRevisions(database)) return notes;
  SQLite::Statement query(database, "SELECT note FROM undo_steps ORDER BY step");
  while (query.executeStep()) notes.push_back(query.getColumn(0).getString());
  return notes;
}

}  // namespace xview
