// SPDX-License-Identifier: BSD-3-Clause
// Rollback journals as the file format of SQLite has them (sqlite.org/fileformat2.html, section 3).
#include "map_journal.h"

#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <thread>

#include "map_tables.h"
#include "xview/base/error.h"

namespace xview::map {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic("\xD9\xD5\x05\xF9\x20\xA1\x63\xD7", 8);
constexpr std::size_t kHeader = 28;  ///< what is read of a header [bytes]

std::uint32_t numberIn(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = at; i < at + 4; ++i)
    number = number << 8 | static_cast<std::uint8_t>(bytes[i]);
  return number;
}

bool isPowerOf2(std::uint32_t number, std::uint32_t low, std::uint32_t high) {
  return number >= low && number <= high && (number & (number - 1)) == 0;
}

struct ReadFile {
  explicit ReadFile(const std::string& path) : stream(path, std::ios::binary) {
    std::error_code ignored;
    const auto bytes = fs::file_size(path, ignored);
    if (!ignored) size = bytes;
  }
  /// As many bytes as there are.
  std::string at(std::uint64_t position, std::size_t bytes) {
    std::string read(bytes, '\0');
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(position));
    stream.read(read.data(), static_cast<std::streamsize>(bytes));
    read.resize(static_cast<std::size_t>(stream.gcount()));
    return read;
  }
  std::ifstream stream;
  std::uint64_t size = 0;
};

/// The header at the begin of a journal, and at that of every part of it.
struct JournalHeader {
  std::uint32_t records, nonce, pages, sector, page_bytes;
};

/// Magic and number of records are zeros until the records have reached the disk. SQLite does not
/// use such a journal.
const std::string kUnused(12, '\0');

std::optional<JournalHeader> headerAt(ReadFile& journal, std::uint64_t position,
                                      std::string_view begin = kMagic) {
  const std::string bytes = journal.at(position, kHeader);
  if (bytes.size() < kHeader || bytes.compare(0, begin.size(), begin) != 0) return std::nullopt;
  return JournalHeader{numberIn(bytes, 8), numberIn(bytes, 12), numberIn(bytes, 16),
                       numberIn(bytes, 20), numberIn(bytes, 24)};
}

/// Of the bytes of a page before the change.
std::uint32_t sumOf(const std::string& page, std::uint32_t nonce) {
  for (std::size_t at = page.size() - 200; at < page.size() && at > 0; at -= 200)
    nonce += static_cast<std::uint8_t>(page[at]);
  return nonce;
}

/// The first page of the map before the change, which is in the journal if it has been overwritten.
/// As SQLite does, this reads up to the first record that was not written to its end.
std::string firstPageIn(ReadFile& journal, const JournalHeader& first) {
  const std::uint64_t record_bytes = first.page_bytes + 8;
  std::uint64_t position = 0;
  for (auto part = std::optional(first); part; part = headerAt(journal, position)) {
    position += first.sector;
    for (std::uint32_t i = 0; i < part->records; ++i, position += record_bytes) {
      const std::string record = journal.at(position, record_bytes);
      if (record.size() < record_bytes) return "";
      const std::string page = record.substr(4, first.page_bytes);
      if (numberIn(record, 4 + first.page_bytes) != sumOf(page, part->nonce)) return "";
      const std::uint32_t number = numberIn(record, 0);
      if (number <= 1) return number == 1 ? page : "";
    }
    if (part->records == 0) return "";
    position = (position + first.sector - 1) / first.sector * first.sector;
  }
  return "";
}

/// Why SQLite must not see this journal of a map; empty if it may. The map is read first: what a
/// living writer has changed in it is in its journal by then.
std::string whyForeign(const std::string& map_path, const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return "";
  if (!S_ISREG(found.st_mode)) return "is no regular file";
  ReadFile map(map_path);
  std::string page = map.at(0, 100);
  ReadFile journal(path);
  if (!journal.stream) return ::access(path.c_str(), F_OK) == 0 ? "cannot be read" : "";
  if (journal.size == 0) return "";  // the writer was killed before its first byte
  if (journal.size >= 16 && journal.at(journal.size - kMagic.size(), kMagic.size()) == kMagic)
    return "names another file, which would be deleted";
  const auto unused = headerAt(journal, 0, kUnused);
  const auto header = unused ? unused : headerAt(journal, 0);
  if (!header || page.size() < 100) return "does not begin as a journal does";
  const std::uint32_t stored = numberIn(page, 16) >> 16;
  const std::uint32_t page_bytes = stored == 1 ? 65536 : stored;
  if (header->page_bytes != page_bytes || !isPowerOf2(page_bytes, 512, 65536) ||
      !isPowerOf2(header->sector, 32, 65536))
    return "has pages of " + std::to_string(header->page_bytes) + " bytes, the map has pages of " +
           std::to_string(page_bytes);
  if (unused) return "";
  if (const std::string former = firstPageIn(journal, *header); !former.empty()) page = former;
  if (numberIn(page, 68) != kMapApplicationId) return "is of a database that is no map";
  const std::uint32_t pages = numberIn(page, 28);
  if (header->pages < pages || header->pages > map.size / page_bytes)
    return "is of a map of " + std::to_string(header->pages) + " pages, this one has " +
           std::to_string(pages);
  return "";
}

/// Of the file itself, as SQLite has it, if the path is a link.
std::string besides(const std::string& path, const char* ending) {
  std::error_code failed;
  const fs::path file = fs::canonical(path, failed);
  return (failed ? path : file.string()) + ending;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw Error(path, why +
                        ": it was not left by a change of this map and is not used; move it away "
                        "to read the map without it");
}

}  // namespace

void requireOwnJournal(const std::string& path) {
  const std::string log = besides(path, "-wal"), journal = besides(path, "-journal");
  struct stat found {};
  if (::lstat(log.c_str(), &found) == 0 && (!S_ISREG(found.st_mode) || found.st_size > 0))
    refuse(log, "is a write-ahead log, which maps do not have");
  // A living writer may have begun its next change between two looks at the files.
  constexpr int kLooks = 4;
  std::string why;
  for (int i = 0; i < kLooks; ++i) {
    if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    why = whyForeign(path, journal);
    if (why.empty()) return;
  }
  refuse(journal, why);
}

void requireNoJournal(const std::string& path) {
  for (const char* ending : {"-journal", "-wal"}) {
    const std::string beside = besides(path, ending);
    struct stat found {};
    if (::lstat(beside.c_str(), &found) == 0 && (!S_ISREG(found.st_mode) || found.st_size > 0))
      throw Error(beside, "lies there already: it would change the new map " + path +
                              "; move it away, or choose another name");
  }
}

}  // namespace xview::map
