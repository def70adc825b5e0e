// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "base/user_text.h"
#include "map_tiles.h"
#include "xview/map/semantic_map.h"

namespace xview::map {

constexpr std::uint32_t kMapApplicationId = 0x78766D70;  // "xvmp"

struct MapTable {
  std::string name;
  const char* definition;  ///< what stands between the brackets of CREATE TABLE; comments show in
                           ///< `sqlite3 FILE .schema`
};

/// All tables with content, each with an integer primary key `id`; `checksums` is the last and
/// covers the others.
extern const std::array<MapTable, 10> kMapTables;

/// Nothing that a file defines is trusted.
void configure(SQLite::Database& database);

/// Creates the empty tables in a schema of the connection ("main", or an attached one).
void createMapTables(SQLite::Database& database, const std::string& schema);

/// Throws Damage if a table is missing or defined otherwise, or if the file has triggers or views,
/// which we never write.
void checkMapTables(SQLite::Database& database);

/// The same before rows are changed: throws Damage also if a table of former rows, or an index,
/// would run something that others wrote.
void checkBeforeWriting(SQLite::Database& database);

/// Hash over all values of a table in order. It notices what SQLite does not: a changed byte inside
/// a value.
class ContentHash {
 public:
  void add(std::int64_t value) { mix(static_cast<std::uint64_t>(value)); }
  void add(double value);
  void add(const void* data, std::size_t size);
  std::int64_t value() const { return static_cast<std::int64_t>(state_ ^ (state_ >> 29)); }

 private:
  void mix(std::uint64_t value) {
    state_ = ((state_ << 23) | (state_ >> 41)) ^ value;
    state_ *= 0x9E3779B97F4A7C15ull;
  }
  std::uint64_t state_ = 0x78766D617073ull;
};

// RowWriter and RowReader take columns in the order of the table, so that one function lists the
// columns of a noun for both directions:
//   template <class Row> void columns(Row& row, Thing& thing) { row(thing.a); row(thing.b); }
// An enumerator stands as its name.

/// Fills a table row by row.
class RowWriter {
 public:
  RowWriter(SQLite::Database& database, const std::string& table);

  template <class Integer, class = std::enable_if_t<std::is_integral_v<Integer>>>
  void operator()(Integer value) {
    bindInteger(static_cast<std::int64_t>(value));
  }
  void operator()(double value);
  void operator()(const std::string& text);
  void operator()(const Bytes& blob);
  template <class Enum>
  void named(Enum value, Enum /*last*/, const char* /*what*/) {
    (*this)(std::string(toString(value)));
  }
  void endRow();
  std::int64_t hash() const { return hash_.value(); }

 private:
  void bindInteger(std::int64_t value);

  SQLite::Statement statement_;
  int next_ = 1;
  ContentHash hash_;
};

/// Reads a table in the order of its ids.
class RowReader {
 public:
  RowReader(SQLite::Database& database, const std::string& table);

  /// To the next row; false at the end.
  bool nextRow();
  template <class Integer, class = std::enable_if_t<std::is_integral_v<Integer>>>
  void operator()(Integer& value) {
    const std::int64_t stored = integer();
    if (stored < static_cast<std::int64_t>(std::numeric_limits<Integer>::min()) ||
        stored > static_cast<std::int64_t>(std::numeric_limits<Integer>::max())) {
      throw Damage("table " + table_ + ": value " + std::to_string(stored) + " out of range");
    }
    value = static_cast<Integer>(stored);
  }
  void operator()(double& value);
  void operator()(std::string& text);
  void operator()(Bytes& blob);
  template <class Enum>
  void named(Enum& value, Enum last, const char* what) {
    std::string name;
    (*this)(name);
    const auto found = enumeratorNamed(name, last);
    if (!found) throw Damage(table_ + ": unknown " + what + " " + name);
    value = *found;
  }
  /// Throws Damage if the values read were not those written.
  void verify(std::int64_t expected_hash) const;

 private:
  std::int64_t integer();

  std::string table_;
  SQLite::Statement statement_;
  int next_ = 0;
  ContentHash hash_;
};

/// Fills the empty tables of a schema ("main", or an attached one). Throws std::logic_error if
/// the map cannot be written as it is.
void writeContent(SQLite::Database& database, const std::string& schema, const SemanticMap& map);

/// Reads the tables of "main", of which much stays packed (openMap); throws Damage.
SemanticMap readContent(SQLite::Database& database);

// Revisions. All of these run inside a transaction of the caller.

void dropFreshTables(SQLite::Database& database);

/// Makes the tables of "main" equal to those of the attached schema "fresh"; rows that do not
/// differ are not touched.
void takeOverFresh(SQLite::Database& database);

/// Notes which rows takeOverFresh is going to change, and what was added.
void recordRevision(SQLite::Database& database, const std::string& note, const Visit* visit);

/// The changes on record, oldest first.
std::vector<Revision> revisionsIn(SQLite::Database& database);

/// Throws Damage; nothing if the change at that position added nothing.
std::optional<Visit> visitOf(SQLite::Database& database, std::size_t revision);

/// Restores the rows before the last recorded revision and forgets it; false if there is none.
bool restoreRevision(SQLite::Database& database);

void forgetRevisions(SQLite::Database& database);

}  // namespace xview::map
