// SPDX-License-Identifier: BSD-3-Clause
// Table undo_steps lists the revisions; undo_added the keys of rows that a revision wrote; and
// undo_<table> the rows that it removed or overwrote. They exist only in files that have a
// revision.
#include <SQLiteCpp/Statement.h>

#include "map_content.h"
#include "map_tables.h"

namespace xview::map {
namespace {

bool hasRevisions(SQLite::Database& database) { return database.tableExists("undo_steps"); }

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

void replaceAll(std::string& text, const std::string& word, const std::string& replacement) {
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at)) {
    text.replace(at, word.size(), replacement);
    at += replacement.size();
  }
}

/// Runs the statements once for every table, with its name for {table}, its columns for {columns}
/// and the number of the revision for {step}.
void executeForEachTable(SQLite::Database& database, const std::string& statements, int step = 0) {
  for (const MapTable& table : kMapTables) {
    std::string sql = statements;
    replaceAll(sql, "{table}", table.name);
    replaceAll(sql, "{step}", std::to_string(step));
    if (sql.find("{columns}") != std::string::npos)
      replaceAll(sql, "{columns}", columnsOf(database, table.name));
    database.exec(sql);
  }
}

void createRevisionTables(SQLite::Database& database) {
  if (hasRevisions(database)) return;
  database.exec("CREATE TABLE undo_steps(step INTEGER PRIMARY KEY, note TEXT)");
  database.exec("CREATE TABLE undo_added(step INTEGER, table_name TEXT, id INTEGER)");
  executeForEachTable(database,
                      "CREATE TABLE undo_{table} AS SELECT 0 AS step, * FROM main.{table} WHERE 0");
}

}  // namespace

void takeOverFresh(SQLite::Database& database) {
  executeForEachTable(database, R"(
    DELETE FROM main.{table} WHERE id IN (SELECT id FROM (
      SELECT * FROM main.{table} EXCEPT SELECT * FROM fresh.{table}));
    INSERT INTO main.{table} SELECT * FROM fresh.{table}
      WHERE id NOT IN (SELECT id FROM main.{table}) ORDER BY id;)");
}

void recordRevision(SQLite::Database& database, const std::string& note) {
  createRevisionTables(database);
  const int step = lastStep(database) + 1;
  SQLite::Statement insert(database, "INSERT INTO undo_steps VALUES(?, ?)");
  insert.bind(1, step);
  insert.bind(2, note);
  insert.exec();
  executeForEachTable(database, R"(
    INSERT INTO undo_{table} SELECT {step}, * FROM (
      SELECT * FROM main.{table} EXCEPT SELECT * FROM fresh.{table});
    INSERT INTO undo_added SELECT {step}, '{table}', id FROM (
      SELECT * FROM fresh.{table} EXCEPT SELECT * FROM main.{table});)",
                      step);
}

bool restoreRevision(SQLite::Database& database) {
  if (!hasRevisions(database)) return false;
  const int step = lastStep(database);
  if (step == 0) return false;
  executeForEachTable(database, R"(
    DELETE FROM {table} WHERE id IN (
      SELECT id FROM undo_added WHERE step = {step} AND table_name = '{table}');
    INSERT INTO {table} SELECT {columns} FROM undo_{table} WHERE step = {step} ORDER BY id;
    DELETE FROM undo_{table} WHERE step = {step};)",
                      step);
  database.exec("DELETE FROM undo_added WHERE step = " + std::to_string(step));
  database.exec("DELETE FROM undo_steps WHERE step = " + std::to_string(step));
  if (step == 1) forgetRevisions(database);
  return true;
}

void forgetRevisions(SQLite::Database& database) {
  database.exec("DROP TABLE IF EXISTS undo_steps");
  database.exec("DROP TABLE IF EXISTS undo_added");
  executeForEachTable(database, "DROP TABLE IF EXISTS undo_{table}");
}

std::vector<std::string> revisionNotes(SQLite::Database& database) {
  std::vector<std::string> notes;
  if (!hasRevisions(database)) return notes;
  SQLite::Statement query(database, "SELECT note FROM undo_steps ORDER BY step");
  while (query.executeStep()) notes.push_back(query.getColumn(0).getString());
  return notes;
}

}  // namespace xview::map
