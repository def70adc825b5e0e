// SPDX-License-Identifier: BSD-3-Clause
// Databases of rosbag2: tables `topics` and `messages`.
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include "bag_file.h"
#include "messages.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

/// The first bytes of a database, as the file format of SQLite has them: big-endian.
struct Header {
  std::string magic;
  std::uint64_t bytes = 0;  ///< of the whole file
};

Header readHeader(InputFile& file) {
  std::string begin(std::min<std::uint64_t>(file.size(), 32), '\0');
  file.readBytes(begin.data(), begin.size());
  Header header{begin.substr(0, 16), 0};
  if (begin.size() < 32) return header;
  const std::uint64_t page = storedNumber<std::uint16_t>(begin.data() + 16, true);
  header.bytes = (page == 1 ? 65536 : page) * storedNumber<std::uint32_t>(begin.data() + 28, true);
  return header;
}

/// SQLite looks for it beside the file itself if the path is a link.
std::string besides(const std::string& path, const char* ending) {
  std::error_code failed;
  const fs::path file = fs::canonical(path, failed);
  return (failed ? path : file.string()) + ending;
}

/// Of changes that the recorder has not taken into the file yet: it is at work, or was killed.
std::uint64_t logBytes(const std::string& path) {
  std::error_code failed;
  const std::uint64_t bytes = fs::file_size(besides(path, "-wal"), failed);
  return failed ? 0 : bytes;
}

/// Nothing is written, neither the file nor beside it: its journal is not looked at, and its
/// write-ahead log is read with an index in memory, unless a recorder has made one.
SQLite::Database openReadOnly(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path)
    uri += c == '?' || c == '#' || c == '%' ? fmt::format("%{:02x}", c) : std::string(1, c);
  const bool has_log = logBytes(path) > 0,
             has_index = fs::is_regular_file(fs::symlink_status(besides(path, "-shm")));
  const char* how = !has_log    ? "?mode=ro&immutable=1"
                    : has_index ? "?mode=ro&readonly_shm=1"
                                : "?mode=ro&vfs=unix-none";
  SQLite::Database database(uri + how, SQLite::OPEN_READONLY | SQLite::OPEN_URI);
  sqlite3_db_config(database.getHandle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  if (has_log && !has_index) database.exec("PRAGMA locking_mode = EXCLUSIVE");  // index in memory
  database.exec("PRAGMA trusted_schema = OFF");
  database.exec("PRAGMA cell_size_check = ON");
  database.exec("PRAGMA writable_schema = ON");  // reads what there is of a file that was cut off
  return database;
}

/// Bounds what statements take by what the file has: rows may lie upon one another in a file that
/// lies.
class Effort {
 public:
  Effort(sqlite3* database, std::uint64_t bytes)
      : database_(database),
        most_steps_(10'000'000 + 10 * bytes),
        most_pages_(100'000 + bytes / 5) {
    const std::uint64_t longest = std::clamp<std::uint64_t>(bytes, 1'000'000, 2'000'000'000);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(longest));
    sqlite3_progress_handler(database, kSteps, isTooMuch, this);
  }
  ~Effort() { sqlite3_progress_handler(database_, 0, nullptr, nullptr); }
  Effort(const Effort&) = delete;
  Effort& operator=(const Effort&) = delete;

 private:
  static constexpr int kSteps = 1000;  ///< between two questions
  static int isTooMuch(void* self) {
    auto& effort = *static_cast<Effort*>(self);
    effort.steps_ += kSteps;
    std::uint64_t pages = 0;
    for (const int kind : {SQLITE_DBSTATUS_CACHE_HIT, SQLITE_DBSTATUS_CACHE_MISS}) {
      int now = 0, most = 0;
      sqlite3_db_status(effort.database_, kind, &now, &most, 0);
      pages += static_cast<std::uint64_t>(std::max(now, 0));
    }
    return effort.steps_ > effort.most_steps_ || pages > effort.most_pages_ ? 1 : 0;
  }

  sqlite3* database_;
  std::uint64_t most_steps_, most_pages_, steps_ = 0;
};

class DatabaseFile final : public BagFile {
 public:
  explicit DatabaseFile(const std::string& path) : BagFile(path), database_(opened()) {
    try {
      const Effort effort(database_.getHandle(), bytes_);
      requireTables();
      readTopics();
      readMessages();
    } catch (const SQLite::Exception& problem) {
      file_.fail("{}", describe(problem));
    }
    for (auto& [id, channel] : by_id_) {
      if (is_cut_) dropUnreadable(channel.messages);
      channels_.push_back(std::move(channel));
    }
    by_id_.clear();
  }

  std::string read(const MessageAt& message, std::uint64_t most_bytes) const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    sqlite3_blob* opened = nullptr;
    const int state = sqlite3_blob_open(database_.getHandle(), "main", "messages", "data",
                                        static_cast<sqlite3_int64>(message.position), 0, &opened);
    const std::unique_ptr<sqlite3_blob, int (*)(sqlite3_blob*)> blob(opened, sqlite3_blob_close);
    if (state != SQLITE_OK) file_.fail("row {}: {}", message.position, sqlite3_errstr(state));
    const auto size = static_cast<std::uint64_t>(sqlite3_blob_bytes(opened));
    if (size > bytes_) file_.fail("row {} has {} bytes", message.position, size);
    std::string bytes(std::min(size, most_bytes), '\0');
    if (sqlite3_blob_read(opened, bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK)
      file_.fail("row {} is damaged; {}", message.position, mend());
    return bytes;
  }

 private:
  SQLite::Database opened() {
    const Header header = readHeader(file_);
    if (header.magic != std::string("SQLite format 3\0", 16))
      file_.fail("expected an SQLite database, found {}", io::inQuotes(header.magic));
    const std::uint64_t log_bytes = logBytes(file_.path());
    bytes_ = file_.size() + log_bytes;
    is_cut_ = log_bytes == 0 && header.bytes > file_.size();
    if (is_cut_)
      notes_.push_back(fmt::format("breaks off at byte {} of {}; what is before is read, {}",
                                   file_.size(), header.bytes, mend()));
    try {
      return openReadOnly(file_.path());
    } catch (const SQLite::Exception& problem) {
      file_.fail("cannot open: {}", problem.what());
    }
  }

  std::string mend() const {
    return fmt::format("to mend it: sqlite3 {} .recover | sqlite3 MENDED.db3", file_.path());
  }
  std::string describe(const SQLite::Exception& problem) const {
    if (problem.getErrorCode() == SQLITE_INTERRUPT)
      return fmt::format("takes more steps to list than a database of {} bytes should", bytes_);
    const bool is_damaged = problem.getErrorCode() == SQLITE_CORRUPT;
    return sqlite3_errstr(problem.getErrorCode()) + (is_damaged ? "; " + mend() : std::string());
  }

  /// What else a schema may define would compute, for ever if it likes: views, triggers, virtual
  /// tables and generated columns. Names are the same in any case.
  void requireTables() {
    SQLite::Statement others(
        database_,
        "SELECT name FROM sqlite_master WHERE sql IS NOT NULL AND NOT (sql GLOB 'CREATE TABLE *' "
        "OR sql GLOB 'CREATE INDEX *' OR sql GLOB 'CREATE UNIQUE INDEX *')");
    if (others.executeStep())
      file_.fail("expected a database of rosbag2, which has only tables and indices, found {}",
                 io::inQuotes(others.getColumn(0).getString()));
    for (const char* name : {"topics", "messages"}) {
      SQLite::Statement query(database_,
                              "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND "
                              "name = ? COLLATE NOCASE");
      query.bind(1, name);
      query.executeStep();
      if (query.getColumn(0).getInt() != 1)
        file_.fail("expected a database of rosbag2, found {} the table {}",
                   query.getColumn(0).getInt() == 0 ? "none with" : "one with several times", name);
      SQLite::Statement computed(database_, "SELECT name FROM pragma_table_xinfo(?) WHERE hidden");
      computed.bind(1, name);
      if (computed.executeStep())
        file_.fail("expected a database of rosbag2, found the computed column {} of the table {}",
                   io::inQuotes(computed.getColumn(0).getString()), name);
    }
  }

  void readTopics() {
    SQLite::Statement row(database_,
                          "SELECT id, name, type, serialization_format FROM topics NOT INDEXED");
    while (row.executeStep()) {
      Channel& channel = by_id_[row.getColumn(0).getInt64()];
      channel.topic = row.getColumn(1).getString();
      channel.type = plainType(row.getColumn(2).getString());
      const std::string format = row.getColumn(3).getString();
      if (format != "cdr") channel.type += " (" + format + ")";  // which no reader knows
    }
  }

  /// Up to where the file is damaged. Their data are not read.
  void readMessages() {
    std::size_t rows = 0;
    try {
      SQLite::Statement row(database_,
                            "SELECT rowid, topic_id, timestamp FROM messages NOT INDEXED");
      for (; row.executeStep(); ++rows) {
        const auto channel = by_id_.find(row.getColumn(1).getInt64());
        if (channel == by_id_.end()) continue;
        channel->second.add({row.getColumn(2).getInt64(),
                             static_cast<std::uint64_t>(row.getColumn(0).getInt64()), 0, 0});
        if (!isKnown(channel->second)) channel->second.messages.clear();
      }
    } catch (const SQLite::Exception& problem) {
      if (problem.getErrorCode() == SQLITE_INTERRUPT) throw;
      if (is_cut_) return;
      notes_.push_back(fmt::format("breaks off behind its row {}: {}", rows, describe(problem)));
    }
  }

  /// Rows may be there whose data are not.
  void dropUnreadable(std::vector<MessageAt>& messages) {
    const auto isLost = [&](const MessageAt& message) {
      if (tried_bytes_ > mostUnpacked(file_)) return true;
      try {
        tried_bytes_ += read(message, file_.size()).size();
        return false;
      } catch (const Error&) {
        return true;
      }
    };
    messages.erase(std::remove_if(messages.begin(), messages.end(), isLost), messages.end());
  }

  bool is_cut_ = false;            ///< shorter than it says
  std::uint64_t bytes_ = 0;        ///< with its write-ahead log
  std::uint64_t tried_bytes_ = 0;  ///< of a file that is cut off
  SQLite::Database database_;
  std::map<std::int64_t, Channel> by_id_;
  mutable std::mutex mutex_;
};

}  // namespace

std::unique_ptr<BagFile> openDatabase(const std::string& path) {
  return std::make_unique<DatabaseFile>(path);
}

}  // namespace xview::io
