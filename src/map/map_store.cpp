// SPDX-License-Identifier: BSD-3-Clause
#include "xview/map/semantic_map.h"

#include <SQLiteCpp/Backup.h>
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Transaction.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>

#include "map/contents.h"
#include "map_journal.h"
#include "map_tables.h"
#include "packed_cloud.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"

namespace xview::map {
namespace {

namespace fs = std::filesystem;

constexpr int kBusy_ms = 5000;  // how long another program's transaction is waited for

/// What the first 100 bytes tell, before SQLite sees the file; nothing if it is no database.
std::optional<SQLite::Header> headerOf(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return std::nullopt;
  try {
    return SQLite::Database::getHeaderInfo(path);
  } catch (const SQLite::Exception&) {
    return std::nullopt;
  }
}

std::uint32_t applicationOf(const SQLite::Header& header) {
  return static_cast<std::uint32_t>(header.applicationId);
}

void requireMapFile(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw Error(path, "no such map");
  if (!fs::is_regular_file(path, ignored))
    throw Error(path, "not a map file: expected a regular file");
  if (::access(path.c_str(), R_OK) != 0)
    throw Error(path, std::string("cannot be read: ") + std::strerror(errno));
  const auto header = headerOf(path);
  if (!header) throw Error(path, "not a map file: expected an SQLite database");
  if (applicationOf(*header) != kMapApplicationId) {
    throw Error(path, "not a map file: application id of the database is " +
                          std::to_string(applicationOf(*header)) + ", expected " +
                          std::to_string(kMapApplicationId));
  }
  const auto version = static_cast<std::int32_t>(header->userVersion);
  if (version != kMapSchemaVersion) {
    throw Error(path, "map of schema version " + std::to_string(version) +
                          ", but this program reads version " + std::to_string(kMapSchemaVersion) +
                          "; make it again with xview map");
  }
  // We never use a write-ahead log, and with one SQLite would create files beside a map that is
  // only read.
  if (header->fileFormatWriteVersion != 1 || header->fileFormatReadVersion != 1)
    throw Error(path, "damaged map file: unknown kind of journal");
  requireOwnJournal(path);
}

// ---- connections

/// A writer that was killed leaves a journal. Opening the map for writing rolls its unfinished
/// change back.
void rollBackIfInterrupted(const std::string& path) {
  SQLite::Database database(path, SQLite::OPEN_READONLY, kBusy_ms);
  const char* const query = "SELECT count(*) FROM sqlite_master";
  if (database.tryExec(query) == SQLite::OK ||
      database.getExtendedErrorCode() != SQLITE_READONLY_ROLLBACK)
    return;
  try {
    SQLite::Database(path, SQLite::OPEN_READWRITE, kBusy_ms).exec(query);
  } catch (const SQLite::Exception& e) {
    throw Error(
        path,
        std::string("an interrupted change must be rolled back first, which fails: ") + e.what());
  }
}

SQLite::Database openForReading(const std::string& path) {
  requireMapFile(path);
  rollBackIfInterrupted(path);
  SQLite::Database database(path, SQLite::OPEN_READONLY, kBusy_ms);
  configure(database);
  return database;
}

SQLite::Database openForWriting(const std::string& path) {
  requireMapFile(path);
  SQLite::Database database(path, SQLite::OPEN_READWRITE, kBusy_ms);
  configure(database);
  return database;
}

/// SQLite quotes what it stumbles over, with its line breaks.
std::string oneLine(const std::string& message) {
  constexpr std::size_t kEnough = 160;
  std::string line = message.substr(0, kEnough);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return line;
}

/// Runs an action on a map file; whatever goes wrong becomes one Error with the path.
template <class Action>
auto guarded(const std::string& path, const char* what, Action&& action) {
  try {
    return action();
  } catch (const Damage& e) {
    throw Error(path, std::string("damaged map file: ") + oneLine(e.what()));
  } catch (const SQLite::Exception& e) {
    const int code = e.getErrorCode();
    const bool damaged = code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
    throw Error(path, std::string(damaged ? "damaged map file" : what) + ": " + oneLine(e.what()));
  } catch (const std::logic_error& e) {
    throw Error(path, std::string(what) + ": " + oneLine(e.what()));
  } catch (const std::bad_alloc&) {
    throw Error(path, std::string(what) + ": out of memory");
  }
}

// ---- a new file

/// So that a file that was renamed in it is found there after a power cut, too.
void syncFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

void writeNewDatabase(const std::string& path, const SemanticMap& map) {
  SQLite::Database database(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec("PRAGMA page_size = 4096");
  database.exec("PRAGMA journal_mode = OFF");  // an incomplete file is removed as a whole
  database.exec("PRAGMA synchronous = OFF");
  database.exec("PRAGMA application_id = " + std::to_string(kMapApplicationId));
  database.exec("PRAGMA user_version = " + std::to_string(kMapSchemaVersion));
  SQLite::Transaction transaction(database);
  createMapTables(database, "main");
  writeContent(database, "main", map);
  transaction.commit();
}

void saveNew(const std::string& path, const SemanticMap& map) {
  requireNoJournal(path);
  AtomicFile file(path);
  writeNewDatabase(file.temporaryPath(), map);
  file.commit();
  syncFolder(fs::path(path).parent_path());
}

// ---- an existing file

/// A connection on which the content of a map is replaced, once or several times.
class Replacement {
 public:
  explicit Replacement(const std::string& path) : database_(openForWriting(path)) {
    SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
    checkBeforeWriting(database_);
    transaction.commit();
    database_.exec("ATTACH ':memory:' AS fresh");
  }

  /// prepare(database) runs inside the transaction, before the tables change.
  template <class Prepare>
  void write(const SemanticMap& map, Prepare&& prepare) {
    createMapTables(database_, "fresh");
    writeContent(database_, "fresh", map);
    if (!transaction_) {
      transaction_.emplace(database_, SQLite::TransactionBehavior::IMMEDIATE);
      checkBeforeWriting(database_);  // another program may have been there
    }
    prepare(database_);
    takeOverFresh(database_);
    dropFreshTables(database_);
  }

  void commit() {
    if (transaction_) transaction_->commit();
  }

 private:
  SQLite::Database database_;
  std::optional<SQLite::Transaction> transaction_;
};

/// Of what was taken out. A map that cannot be made smaller is a whole one.
void freeUnusedPages(SQLite::Database& database) {
  try {
    database.exec("VACUUM");
  } catch (const SQLite::Exception&) {
  }
}

constexpr const char* kCannotWrite = "the map cannot be written";
constexpr const char* kCannotRead = "the map cannot be read";

}  // namespace

bool isMapFile(const std::string& path) {
  const auto header = headerOf(path);
  return header && applicationOf(*header) == kMapApplicationId;
}

void saveMap(const std::string& path, const SemanticMap& map) {
  guarded(path, kCannotWrite, [&] {
    std::error_code ignored;
    const bool fresh = !fs::exists(path, ignored) ||
                       (fs::is_regular_file(path, ignored) && fs::file_size(path, ignored) == 0);
    if (fresh) {
      saveNew(path, map);
    } else {
      Replacement change(path);
      change.write(map, forgetRevisions);
      change.commit();
    }
  });
}

void saveRevision(const std::string& path, const SemanticMap& map, const std::string& note,
                  const Visit* visit) {
  MapChanges changes(path);
  changes.add(map, note, visit);
  changes.commit();
}

struct MapChanges::Connection : Replacement {
  using Replacement::Replacement;
};

MapChanges::MapChanges(std::string path) : path_(std::move(path)) { requireMapFile(path_); }
MapChanges::~MapChanges() = default;
MapChanges::MapChanges(MapChanges&&) noexcept = default;

void MapChanges::add(const SemanticMap& map, const std::string& note, const Visit* visit) {
  guarded(path_, kCannotWrite, [&] {
    if (!connection_) connection_ = std::make_unique<Connection>(path_);
    connection_->write(map,
                       [&](SQLite::Database& database) { recordRevision(database, note, visit); });
  });
}

void MapChanges::commit() {
  guarded(path_, kCannotWrite, [&] {
    if (connection_) connection_->commit();
    connection_.reset();
  });
}

void replaceMap(const std::string& path, const std::string& other) {
  guarded(path, kCannotWrite, [&] {
    SQLite::Database database = openForWriting(path), source = openForReading(other);
    SQLite::Backup(database, source).executeStep();
  });
}

std::vector<Revision> readRevisions(const std::string& path) {
  return guarded(path, kCannotRead, [&] {
    SQLite::Database database = openForReading(path);
    checkBeforeWriting(database);
    return revisionsIn(database);
  });
}

Visit loadVisit(const std::string& path, std::size_t revision) {
  return guarded(path, kCannotRead, [&] {
    SQLite::Database database = openForReading(path);
    checkBeforeWriting(database);
    std::optional<Visit> visit = visitOf(database, revision);
    if (!visit)
      throw Damage("what change " + std::to_string(revision + 1) + " has added is not on record");
    return std::move(*visit);
  });
}

bool undoRevision(const std::string& path) {
  return guarded(path, kCannotWrite, [&] {
    SQLite::Database database = openForWriting(path);
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    checkBeforeWriting(database);
    if (!restoreRevision(database)) return false;
    unpacked(readContent(database));  // what is damaged must not replace a sound one
    transaction.commit();
    freeUnusedPages(database);
    return true;
  });
}

SemanticMap openMap(const std::string& path) {
  return guarded(path, kCannotRead, [&] {
    SQLite::Database database = openForReading(path);
    const SQLite::Transaction snapshot(database);
    return readContent(database);
  });
}

// SQLite locks with fcntl(), which flock() does not meet; its locks are those of one transaction.
MapLock::MapLock(const std::string& path) : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) return;
  while (flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

MapLock::~MapLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace xview::map
