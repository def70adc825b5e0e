// SPDX-License-Identifier: BSD-3-Clause
#include "map_tables.h"

#include <SQLiteCpp/Column.h>
#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <unordered_set>

#include "packed_cloud.h"

namespace xview::map {
namespace {

std::string definitionOf(const MapTable& table, const std::string& name) {
  return "CREATE TABLE " + name + "(" + table.definition + ")";
}

std::string insertStatement(SQLite::Database& database, const std::string& table) {
  const int columns = SQLite::Statement(database, "SELECT * FROM " + table).getColumnCount();
  std::string sql = "INSERT INTO " + table + " VALUES(?";
  for (int i = 1; i < columns; ++i) sql += ",?";
  return sql + ")";
}

bool hasRevisions(SQLite::Database& database) { return database.tableExists("undo_steps"); }

bool hasVisits(SQLite::Database& database) { return database.tableExists("undo_visits"); }

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

/// FROM and WHERE of the rows `a` of one schema that another has otherwise or not at all.
std::string differencesOf(SQLite::Database& database, const std::string& table,
                          const std::string& schema, const std::string& other) {
  const auto valuesOf = [&](const std::string& name) {
    std::string columns = name + "." + columnsOf(database, table);
    replaceAll(columns, ", ", ", " + name + ".");
    return "(" + columns + ")";
  };
  return "FROM " + schema + "." + table + " a LEFT JOIN " + other + "." + table +
         " b ON b.id = a.id WHERE b.id IS NULL OR " + valuesOf("a") + " IS NOT " + valuesOf("b");
}

/// Runs the statements once for every table, with its name for {table}, its columns for {columns},
/// for {missing in fresh} and {missing in main} the rows of the one that the other has otherwise or
/// not at all, and the number of the revision for {step}.
void executeForEachTable(SQLite::Database& database, const std::string& statements, int step = 0) {
  for (const MapTable& table : kMapTables) {
    std::string sql = statements;
    const auto replace = [&](const std::string& word, const auto& textOf) {
      if (sql.find(word) != std::string::npos) replaceAll(sql, word, textOf());
    };
    replace("{missing in fresh}",
            [&] { return differencesOf(database, table.name, "main", "fresh"); });
    replace("{missing in main}",
            [&] { return differencesOf(database, table.name, "fresh", "main"); });
    replace("{columns}", [&] { return columnsOf(database, table.name); });
    replaceAll(sql, "{table}", table.name);
    replaceAll(sql, "{step}", std::to_string(step));
    database.exec(sql);
  }
}

/// Columns with a type and nothing else: whatever SQLite would compute needs a second bracket.
bool isPlainTable(const std::string& sql, const std::string& name) {
  const std::string begin = "CREATE TABLE " + name + "(";
  return sql.compare(0, begin.size(), begin) == 0 && sql.find('(', begin.size()) == sql.npos;
}

void createRevisionTables(SQLite::Database& database) {
  database.exec(
      "CREATE TABLE IF NOT EXISTS undo_visits(step INTEGER PRIMARY KEY, sigma_m REAL, data BLOB)");
  if (hasRevisions(database)) return;
  database.exec("CREATE TABLE undo_steps(step INTEGER PRIMARY KEY, note TEXT)");
  database.exec("CREATE TABLE undo_added(step INTEGER, table_name TEXT, id INTEGER)");
  executeForEachTable(database,
                      "CREATE TABLE undo_{table} AS SELECT 0 AS step, * FROM main.{table} WHERE 0");
}

/// A map as the bytes of a database of its own.
Bytes databaseOf(const SemanticMap& map) {
  SQLite::Database database(":memory:", SQLite::OPEN_READWRITE);
  createMapTables(database, "main");
  writeContent(database, "main", map);
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, decltype(&sqlite3_free)> bytes(
      sqlite3_serialize(database.getHandle(), "main", &size, 0), &sqlite3_free);
  if (!bytes) throw std::bad_alloc();
  return {bytes.get(), bytes.get() + size};
}

/// Throws Damage.
SemanticMap contentOf(const SQLite::Column& bytes) {
  SQLite::Database database(":memory:", SQLite::OPEN_READWRITE);
  configure(database);
  const auto size = static_cast<sqlite3_int64>(bytes.getBytes());
  auto* copy = static_cast<unsigned char*>(sqlite3_malloc64(static_cast<sqlite3_uint64>(size) + 1));
  if (!copy) throw std::bad_alloc();
  if (size > 0) std::memcpy(copy, bytes.getBlob(), static_cast<std::size_t>(size));
  if (sqlite3_deserialize(database.getHandle(), "main", copy, size, size,
                          SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_READONLY) !=
      SQLITE_OK)
    throw Damage("undo_visits: data is no database");
  return unpacked(readContent(database));
}

}  // namespace

static constexpr const char* kTileTable = R"(
  id INTEGER PRIMARY KEY,
  x INTEGER, y INTEGER, z INTEGER, -- tile of 64 m from the origin
  points INTEGER,
  data BLOB               -- packed, 1 cm
)";

const std::array<MapTable, 10> kMapTables = {{
    {"meta", R"(
  id INTEGER PRIMARY KEY,
  name TEXT,              -- origins in metres: p_map = origin + p
  value TEXT
)"},
    {"labels", R"(
  id INTEGER PRIMARY KEY, -- class id
  name TEXT,
  red INTEGER, green INTEGER, blue INTEGER,
  role TEXT,              -- object, surface, dynamic, ignored
  kind TEXT,
  guessed INTEGER         -- 1: role derived from the name
)"},
    {"sources", R"(
  id INTEGER PRIMARY KEY, -- in order of arrival
  path TEXT
)"},
    {"keyframes", R"(
  id INTEGER PRIMARY KEY,
  number INTEGER,         -- of the frame in its source
  stamp_s REAL,
  source INTEGER,         -- sources.id
  r00 REAL, r01 REAL, r02 REAL, x REAL, -- T_map_sensor, row by row, metres
  r10 REAL, r11 REAL, r12 REAL, y REAL,
  r20 REAL, r21 REAL, r22 REAL, z REAL
)"},
    {"vertices", R"(
  id INTEGER PRIMARY KEY, -- of the first of 1024 vertices
  vertices INTEGER,
  data BLOB               -- packed
)"},
    {"edges", R"(
  id INTEGER PRIMARY KEY, -- vertices.id of the first of 4096 vertices
  edges INTEGER,          -- from these to later vertices
  data BLOB               -- packed
)"},
    {"plan_tiles", kTileTable},
    {"overview_tiles", R"(
  id INTEGER PRIMARY KEY,
  x INTEGER, y INTEGER,   -- tile of 64 x 64 cells of the plan from its origin
  data BLOB               -- packed; for the first look at large maps
)"},
    {"cloud_tiles", kTileTable},
    {"checksums", R"(
  id INTEGER PRIMARY KEY,
  table_name TEXT,
  content INTEGER         -- hash of all values
)"},
}};

void configure(SQLite::Database& database) {
  database.exec("PRAGMA trusted_schema = OFF");
  database.exec("PRAGMA cell_size_check = ON");
  database.exec("PRAGMA temp_store = MEMORY");
}

void createMapTables(SQLite::Database& database, const std::string& schema) {
  for (const MapTable& table : kMapTables) {
    database.exec(definitionOf(table, schema + "." + table.name));
  }
}

void checkMapTables(SQLite::Database& database) {
  SQLite::Statement query(database,
                          "SELECT sql FROM sqlite_master WHERE type = 'table' AND name = ?");
  for (const MapTable& table : kMapTables) {
    query.reset();
    query.bind(1, table.name);
    if (!query.executeStep()) throw Damage("table " + table.name + " is missing");
    if (query.getColumn(0).getString() != definitionOf(table, table.name))
      throw Damage("table " + table.name + " has other columns than expected");
  }
  SQLite::Statement others(database,
                           "SELECT name FROM sqlite_master WHERE type NOT IN ('table', 'index')");
  if (others.executeStep()) throw Damage("unexpected object " + others.getColumn(0).getString());
}

void checkBeforeWriting(SQLite::Database& database) {
  checkMapTables(database);
  SQLite::Statement indices(database,
                            "SELECT name FROM sqlite_master WHERE type = 'index' AND sql NOT NULL");
  if (indices.executeStep())
    throw Damage("unexpected index " + indices.getColumn(0).getString() +
                 "; DROP INDEX removes it");
  SQLite::Statement query(database, "SELECT sql FROM sqlite_master WHERE name = ?");
  std::vector<std::string> names = {"undo_steps", "undo_added", "undo_visits"};
  for (const MapTable& table : kMapTables) names.push_back("undo_" + table.name);
  for (const std::string& name : names) {
    query.reset();
    query.bind(1, name);
    if (query.executeStep() && !isPlainTable(query.getColumn(0).getString(), name))
      throw Damage("table " + name + " is defined otherwise than expected");
  }
}

void ContentHash::add(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  mix(bits);
}

void ContentHash::add(const void* data, std::size_t size) {
  mix(size);
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  for (; size >= 8; size -= 8, bytes += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, 8);
    mix(word);
  }
  for (; size > 0; --size) mix(*bytes++);
}

RowWriter::RowWriter(SQLite::Database& database, const std::string& table)
    : statement_(database, insertStatement(database, table)) {}

void RowWriter::bindInteger(std::int64_t value) {
  statement_.bind(next_++, value);
  hash_.add(value);
}

void RowWriter::operator()(double value) {
  // SQLite knows neither NaN, which becomes NULL, nor the sign of zero.
  value = std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value + 0.0;
  statement_.bind(next_++, value);
  hash_.add(value);
}

void RowWriter::operator()(const std::string& text) {
  statement_.bind(next_++, text);
  hash_.add(text.data(), text.size());
}

void RowWriter::operator()(const Bytes& blob) {
  statement_.bind(next_++, blob.data(), static_cast<int>(blob.size()));
  hash_.add(blob.data(), blob.size());
}

void RowWriter::endRow() {
  statement_.exec();
  statement_.reset();
  next_ = 1;
}

RowReader::RowReader(SQLite::Database& database, const std::string& table)
    : table_(table), statement_(database, "SELECT * FROM " + table + " ORDER BY id") {}

bool RowReader::nextRow() {
  next_ = 0;
  return statement_.executeStep();
}

std::int64_t RowReader::integer() {
  const std::int64_t value = statement_.getColumn(next_++).getInt64();
  hash_.add(value);
  return value;
}

void RowReader::operator()(double& value) {
  const SQLite::Column column = statement_.getColumn(next_++);
  value = column.getDouble();
  if (value == 0 && column.isNull()) value = std::numeric_limits<double>::quiet_NaN();
  hash_.add(value);
}

void RowReader::operator()(std::string& text) {
  text = statement_.getColumn(next_++).getString();
  hash_.add(text.data(), text.size());
}

void RowReader::operator()(Bytes& blob) {
  const SQLite::Column column = statement_.getColumn(next_++);
  const auto* data = static_cast<const std::uint8_t*>(column.getBlob());
  blob.assign(data, data + column.getBytes());
  hash_.add(blob.data(), blob.size());
}

void RowReader::verify(std::int64_t expected_hash) const {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  if (hash_.value() != expected_hash) return;  // random changes are to reach what is behind it
#endif
  if (hash_.value() != expected_hash) throw Damage("table " + table_ + " is not as it was written");
}

void dropFreshTables(SQLite::Database& database) {
  executeForEachTable(database, "DROP TABLE fresh.{table}");
}

void takeOverFresh(SQLite::Database& database) {
  executeForEachTable(database, R"(
    DELETE FROM main.{table} WHERE id IN (SELECT a.id {missing in fresh});
    INSERT INTO main.{table} SELECT * FROM fresh.{table}
      WHERE id NOT IN (SELECT id FROM main.{table}) ORDER BY id;)");
}

void recordRevision(SQLite::Database& database, const std::string& note, const Visit* visit) {
  createRevisionTables(database);
  const int step = lastStep(database) + 1;
  SQLite::Statement insert(database, "INSERT INTO undo_steps VALUES(?, ?)");
  insert.bind(1, step);
  insert.bind(2, note);
  insert.exec();
  if (visit) {
    const Bytes data = databaseOf(visit->place);
    SQLite::Statement keep(database, "INSERT INTO undo_visits VALUES(?, ?, ?)");
    keep.bind(1, step);
    keep.bind(2, visit->sigma_m);
    keep.bind(3, data.data(), static_cast<int>(data.size()));
    keep.exec();
  }
  executeForEachTable(database, R"(
    INSERT INTO undo_{table} SELECT {step}, a.* {missing in fresh} ORDER BY a.id;
    INSERT INTO undo_added SELECT {step}, '{table}', a.id {missing in main} ORDER BY a.id;)",
                      step);
}

std::vector<Revision> revisionsIn(SQLite::Database& database) {
  std::vector<Revision> revisions;
  if (!hasRevisions(database)) return revisions;
  std::unordered_set<std::int64_t> visits;
  if (hasVisits(database)) {
    SQLite::Statement query(database, "SELECT step FROM undo_visits");
    while (query.executeStep()) visits.insert(query.getColumn(0).getInt64());
  }
  SQLite::Statement steps(database, "SELECT step, note FROM undo_steps ORDER BY step");
  while (steps.executeStep())
    revisions.push_back(
        {steps.getColumn(1).getString(), visits.count(steps.getColumn(0).getInt64()) > 0});
  return revisions;
}

std::optional<Visit> visitOf(SQLite::Database& database, std::size_t revision) {
  if (!hasVisits(database)) return std::nullopt;
  SQLite::Statement row(database, "SELECT sigma_m, data FROM undo_visits WHERE step = ?");
  row.bind(1, static_cast<std::int64_t>(revision) + 1);  // steps begin with 1
  if (!row.executeStep()) return std::nullopt;
  Visit visit;
  visit.sigma_m = row.getColumn(0).getDouble();
  if (!(visit.sigma_m >= 0)) throw Damage("undo_visits: sigma_m is no length");
  visit.place = contentOf(row.getColumn(1));
  return visit;
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
  if (hasVisits(database))
    database.exec("DELETE FROM undo_visits WHERE step = " + std::to_string(step));
  database.exec("DELETE FROM undo_added WHERE step = " + std::to_string(step));
  database.exec("DELETE FROM undo_steps WHERE step = " + std::to_string(step));
  if (step == 1) forgetRevisions(database);
  return true;
}

void forgetRevisions(SQLite::Database& database) {
  database.exec("DROP TABLE IF EXISTS undo_steps");
  database.exec("DROP TABLE IF EXISTS undo_added");
  database.exec("DROP TABLE IF EXISTS undo_visits");
  executeForEachTable(database, "DROP TABLE IF EXISTS undo_{table}");
}

}  // namespace xview::map
