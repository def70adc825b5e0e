// SPDX-License-Identifier: BSD-3-Clause
// Databases of rosbag2: tables `topics` and `messages`.
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <filesystem>
#include <map>
#include <mutex>

#include "bag_file.h"
#include "messages.h"
#include "xview/types/error.h"

namespace xview::io {
namespace {

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

/// Nothing is written beside the file, as SQLite would do for a journal; only the changes that lie
/// there already, if the recorder was killed, are taken in.
SQLite::Database openReadOnly(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path)
    uri += c == '?' || c == '#' || c == '%' ? fmt::format("%{:02x}", c) : std::string(1, c);
  std::error_code failed;
  const bool has_log = std::filesystem::file_size(path + "-wal", failed) > 0 && !failed;
  SQLite::Database database(uri + (has_log ? "?mode=ro" : "?mode=ro&immutable=1"),
                            SQLite::OPEN_READONLY | SQLite::OPEN_URI);
  database.exec("PRAGMA trusted_schema = OFF");
  database.exec("PRAGMA cell_size_check = ON");
  database.exec("PRAGMA writable_schema = ON");  // reads what there is of a file that was cut off
  return database;
}

class DatabaseFile final : public BagFile {
 public:
  explicit DatabaseFile(const std::string& path) : BagFile(path), database_(opened()) {
    try {
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
    if (size > file_.size()) file_.fail("row {} has {} bytes", message.position, size);
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
    is_cut_ = header.bytes > file_.size();
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
    const bool is_damaged = problem.getErrorCode() == SQLITE_CORRUPT;
    return sqlite3_errstr(problem.getErrorCode()) + (is_damaged ? "; " + mend() : std::string());
  }

  /// A view of that name could compute for ever.
  void requireTables() {
    for (const char* name : {"topics", "messages"}) {
      SQLite::Statement query(
          database_,
          "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ? AND "
          "sql LIKE 'CREATE TABLE%'");
      query.bind(1, name);
      query.executeStep();
      if (query.getColumn(0).getInt() != 1)
        file_.fail("expected a database of rosbag2, found none with the table {}", name);
    }
  }

  void readTopics() {
    SQLite::Statement row(database_, "SELECT id, name, type, serialization_format FROM topics");
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
      if (is_cut_) return;
      notes_.push_back(fmt::format("breaks off behind its row {}: {}", rows, describe(problem)));
    }
  }

  /// Rows may be there whose data are not.
  void dropUnreadable(std::vector<MessageAt>& messages) const {
    const auto isLost = [&](const MessageAt& message) {
      try {
        read(message, file_.size());
        return false;
      } catch (const Error&) {
        return true;
      }
    };
    messages.erase(std::remove_if(messages.begin(), messages.end(), isLost), messages.end());
  }

  bool is_cut_ = false;  ///< shorter than it says
  SQLite::Database database_;
  std::map<std::int64_t, Channel> by_id_;
  mutable std::mutex mutex_;
};

}  // namespace

std::unique_ptr<BagFile> openDatabase(const std::string& path) {
  return std::make_unique<DatabaseFile>(path);
}

}  // namespace xview::io
