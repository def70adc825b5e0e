// SPDX-License-Identifier: BSD-3-Clause
// Files that are no sound map: each is one Error with the path, never a crash and never a map.
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "../../src/map/map_tables.h"
#include "base/random.h"
#include "map/sample_map.h"
#include "support/sanitizers.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/map/semantic_map.h"

namespace xview::map {
namespace {

namespace fs = std::filesystem;
using test::isSame;
using test::readText;
using test::sampleMap;
using test::TemporaryFolder;
using test::writeText;

/// In one line.
template <class Action>
std::string messageOf(Action&& action) {
  const std::string message = test::messageOf<Error>(action);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

std::string messageOfLoad(const std::string& path) {
  return messageOf([&] { unpacked(openMap(path)); });
}

/// A sample map in a folder of its own, and ways to spoil it.
class DamagedMap : public ::testing::Test {
 protected:
  void SetUp() override {
    saveMap(path_, sampleMap());
    sound_ = readText(path_);
    map_ = unpacked(openMap(path_));
  }
  void execute(const std::string& sql) {
    SQLite::Database(path_, SQLite::OPEN_READWRITE).exec(sql);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "town.xvm";
  std::string sound_;
  SemanticMap map_;
};

TEST_F(DamagedMap, MissingFileIsNamed) {
  EXPECT_EQ(messageOfLoad(folder_ / "none.xvm"), folder_ / "none.xvm: no such map");
  EXPECT_FALSE(isMapFile(folder_ / "none.xvm"));
}

TEST_F(DamagedMap, OtherFilesAreNoMaps) {
  SQLite::Database(folder_ / "other.db", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE meta(id)");
  writeText(folder_ / "empty", "");
  writeText(folder_ / "text", std::string(5000, 'x'));
  writeText(folder_ / "short", sound_.substr(0, 60));
  for (const char* name : {"other.db", "empty", "text", "short", "."}) {
    EXPECT_FALSE(isMapFile(folder_ / name)) << name;
    EXPECT_NE(messageOfLoad(folder_ / name).find("not a map file"), std::string::npos)
        << messageOfLoad(folder_ / name);
  }
  EXPECT_TRUE(isMapFile(path_));
}

TEST_F(DamagedMap, UnknownSchemaVersionIsRefusedAndBothAreNamed) {
  for (const char* version : {"7", "3"}) {
    execute(std::string("PRAGMA user_version = ") + version);
    for (const std::string& message :
         {messageOfLoad(path_), messageOf([&] { saveMap(path_, SemanticMap()); }),
          messageOf([&] { undoRevision(path_); })}) {
      EXPECT_NE(message.find(std::string("version ") + version), std::string::npos) << message;
      EXPECT_NE(message.find("version 4"), std::string::npos) << message;
      EXPECT_NE(message.find("make it again with xview map"), std::string::npos) << message;
    }
  }
}

TEST_F(DamagedMap, FileThatIsNoMapIsNotOverwritten) {
  writeText(folder_ / "thesis.txt", "three years of work");
  EXPECT_NE(messageOf([&] { saveMap(folder_ / "thesis.txt", map_); }).find("not a map file"),
            std::string::npos);
  EXPECT_EQ(readText(folder_ / "thesis.txt"), "three years of work");
}

TEST_F(DamagedMap, TruncationAnywhereIsNoticed) {
  for (std::size_t size = 0; size < sound_.size(); size += 1 + sound_.size() / 97) {
    writeText(path_, sound_.substr(0, size));
    EXPECT_NE(messageOfLoad(path_), "no error") << size;
  }
}

TEST_F(DamagedMap, EveryZeroedPageIsNoticed) {
  constexpr std::size_t kPage = 4096;
  for (std::size_t page = 0; page + kPage <= sound_.size(); page += kPage) {
    std::string bytes = sound_;
    bytes.replace(page, kPage, kPage, '\0');
    writeText(path_, bytes);
    EXPECT_NE(messageOfLoad(path_), "no error") << page;
  }
}

TEST_F(DamagedMap, FlippedBytesGiveTheSoundMapOrAnError) {
  Random random(3);
  int noticed = 0;
  for (int run = 0; run < 400; ++run) {
    std::string bytes = sound_;
    const std::size_t place = random.below(static_cast<std::uint32_t>(bytes.size()));
    bytes[place] = static_cast<char>(bytes[place] ^ (1 + random.below(255)));
    writeText(path_, bytes);
    try {
      EXPECT_TRUE(isSame(unpacked(openMap(path_)), map_))
          << "byte " << place;  // unused bytes of a page, counters
    } catch (const Error& e) {
      ++noticed;
      EXPECT_EQ(std::string(e.what()).rfind(path_ + ": ", 0), 0u) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  EXPECT_GT(noticed, 100);
}

TEST_F(DamagedMap, ManyFlippedBytesNeverCrash) {
  Random random(4);
  for (int run = 0; run < 300; ++run) {
    std::string bytes = sound_;
    for (int k = 0; k < 20; ++k)
      bytes[100 + random.below(30000)] = static_cast<char>(random.below(256));
    writeText(path_, bytes);
    messageOf([&] { EXPECT_TRUE(isSame(unpacked(openMap(path_)), map_)); });
  }
}

TEST_F(DamagedMap, DamagedSchemaGivesOneLine) {
  std::string bytes = sound_;
  bytes[bytes.find("stamp_s REAL")] = '\'';
  writeText(path_, bytes);
  EXPECT_NE(messageOfLoad(path_).find("damaged map file"), std::string::npos)
      << messageOfLoad(path_);
}

TEST_F(DamagedMap, ChangedValueIsNoticed) {
  for (const char* sql :
       {"UPDATE keyframes SET x = x + 1e-9 WHERE id = 0",
        "UPDATE keyframes SET number = 5 WHERE id = 0",
        "UPDATE labels SET name = 'Pole' WHERE id = 3", "DELETE FROM vertices",
        "UPDATE vertices SET id = 1024", "DELETE FROM edges",
        "DELETE FROM cloud_tiles WHERE id = (SELECT max(id) FROM cloud_tiles)",
        "UPDATE meta SET value = '' WHERE name = 'options'", "DELETE FROM checksums",
        "DROP TABLE sources", "ALTER TABLE vertices ADD COLUMN more",
        "CREATE VIEW extra AS SELECT 1"}) {
    writeText(path_, sound_);
    execute(sql);
    EXPECT_NE(messageOfLoad(path_).find("damaged map file"), std::string::npos)
        << sql << ": " << messageOfLoad(path_);
  }
}

/// The largest memory of a process that loads the map, beyond what it has when it starts [MB].
long loadingCosts_mb(const std::string& path) {
  const auto peak_mb = [](int who) {
    rusage usage = {};
    getrusage(who, &usage);
    return usage.ru_maxrss / 1024;
  };
  const pid_t child = fork();
  if (child == 0) {
    const long before = peak_mb(RUSAGE_SELF);
    test::messageOf<Error>([&] { unpacked(openMap(path)); });
    _exit(static_cast<int>(std::min(255L, peak_mb(RUSAGE_SELF) - before)));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 255;
}

/// As it stands in the table `checksums`.
std::int64_t hashOf(SQLite::Database& database, const std::string& table) {
  ContentHash hash;
  SQLite::Statement rows(database, "SELECT * FROM " + table + " ORDER BY id");
  while (rows.executeStep()) {
    hash.add(rows.getColumn(0).getInt64());
    for (int i = 1; i < rows.getColumnCount(); ++i) {
      const std::string text = rows.getColumn(i).getString();
      hash.add(text.data(), text.size());
    }
  }
  return hash.value();
}

/// Makes one tile of the cloud claim eight million points, which are there, too, if they have the
/// five bytes that each needs.
void plantPoints(SQLite::Database& database, std::size_t bytes) {
  const Bytes tile = compressed(Bytes(bytes, 0));
  SQLite::Statement change(database,
                           "UPDATE cloud_tiles SET points = 8000000, data = ? WHERE id = (SELECT "
                           "min(id) FROM cloud_tiles)");
  change.bind(1, tile.data(), static_cast<int>(tile.size()));
  change.exec();
}

/// Check fix for: a map of 0.4 MB took 8 GB. Two counts were not compared before all was unpacked.
TEST_F(DamagedMap, PointsThatAreMoreThanAnnouncedAreNotUnpacked) {
  {
    SQLite::Database database(path_, SQLite::OPEN_READWRITE);
    plantPoints(database, 40000000);
  }
  EXPECT_NE(messageOfLoad(path_).find("damaged map file: cloud_points: "), std::string::npos)
      << messageOfLoad(path_);
  if (!test::kSanitized) {
    EXPECT_LT(loadingCosts_mb(path_), 100);
  }
}

/// Check fix for: nor was their number compared with what a file of this size can hold.
TEST_F(DamagedMap, PointsThatAreMoreThanItsBytesCanHoldAreNotUnpacked) {
  {
    SQLite::Database database(path_, SQLite::OPEN_READWRITE);
    plantPoints(database, 40000000);
    database.exec("UPDATE meta SET value = 999999999 WHERE name = 'cloud_points'");
    const std::int64_t hash = hashOf(database, "meta");
    SQLite::Statement checksum(database,
                               "UPDATE checksums SET content = ? WHERE table_name = 'meta'");
    checksum.bind(1, hash);
    checksum.exec();
  }
  EXPECT_NE(messageOfLoad(path_).find("more than a map of "), std::string::npos)
      << messageOfLoad(path_);
  if (!test::kSanitized) {
    EXPECT_LT(loadingCosts_mb(path_), 100);
  }
}

/// Check fix for: one row per byte was believed, though a row is eight bytes at least.
TEST_F(DamagedMap, RowsThatAreMoreThanTheBytesOfTheirTileAreNotUnpacked) {
  const Tile packed{0, 0, 0, 4000000, compressed(Bytes(4000000, 0))};
  LabelledCloud cloud;
  EXPECT_NE(
      test::messageOf<Damage>([&] { appendTile(packed, cloud); }).find("expected 32000000 to"),
      std::string::npos);
}

// ---- what others put into a file, and what would run it

/// Check fix for: undo ran what a view or a trigger of a foreign file says, before it was looked
/// at.
TEST_F(DamagedMap, NothingOfAForeignFileRunsWhenItIsChanged) {
  saveRevision(path_, map_, "fused");
  sound_ = readText(path_);
  const char* const kEndless =
      "WITH RECURSIVE r(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM r) SELECT 1 AS step, id, '' "
      "AS name, '' AS value FROM r";
  for (const std::string& sql :
       {std::string("DROP TABLE undo_meta; CREATE VIEW undo_meta AS ") + kEndless,
        std::string("CREATE TRIGGER t AFTER DELETE ON undo_steps BEGIN INSERT INTO undo_added "
                    "SELECT 1, 'x', 1; END"),
        std::string("CREATE INDEX i ON vertices(hex(zeroblob(100)))"),
        std::string("DROP TABLE undo_meta; CREATE TABLE undo_meta(step, id, name, value AS "
                    "(hex(zeroblob(100))))"),
        std::string("DROP TABLE undo_meta; CREATE TABLE undo_meta(step, id, name, value, "
                    "CHECK(length(hex(zeroblob(100))) > 0))"),
        std::string("DROP TABLE IF EXISTS undo_visits; CREATE VIEW undo_visits AS ") + kEndless}) {
    writeText(path_, sound_);
    execute(sql);
    const std::string before = readText(path_);
    for (const std::string& message : {messageOf([&] { undoRevision(path_); }),
                                       messageOf([&] { saveRevision(path_, map_, "again"); })}) {
      EXPECT_NE(message.find("damaged map file: "), std::string::npos) << sql << ": " << message;
      EXPECT_TRUE(readText(path_) == before) << sql;
    }
  }
  writeText(path_, sound_);
  EXPECT_TRUE(undoRevision(path_)) << "a map of our own";
}

TEST_F(DamagedMap, AVisitThatIsNoMapIsRefused) {
  const Visit visit{map_, 0.1};
  saveRevision(path_, map_, "fused", &visit);
  sound_ = readText(path_);
  for (const char* sql :
       {"UPDATE undo_visits SET data = x''", "UPDATE undo_visits SET data = zeroblob(5000)",
        "UPDATE undo_visits SET data = 'words'", "UPDATE undo_visits SET data = NULL",
        "UPDATE undo_visits SET data = substr(data, 1, length(data) / 2)",
        "UPDATE undo_visits SET sigma_m = -1"}) {
    writeText(path_, sound_);
    execute(sql);
    const std::string message = messageOf([&] { loadVisit(path_, 0); });
    EXPECT_NE(message.find("damaged map file: "), std::string::npos) << sql << ": " << message;
  }
}

TEST_F(DamagedMap, CountsThatLieDoNotCostMemory) {
  for (const char* sql :
       {"UPDATE cloud_tiles SET points = 4294967295",
        "UPDATE cloud_tiles SET data = x'ffffffff789c0300000000010000'",
        "UPDATE plan_tiles SET points = 4294967295", "UPDATE plan_tiles SET data = zeroblob(100)",
        "UPDATE vertices SET vertices = 4294967295",
        "UPDATE vertices SET data = x'ffffffff789c0300000000010000'",
        "UPDATE edges SET edges = 4294967295",
        "UPDATE edges SET data = x'01000000789c0300000000ff'",
        "UPDATE plan_tiles SET x = 9223372036854775807",
        "UPDATE cloud_tiles SET z = -9223372036854775808",
        "UPDATE edges SET id = 9223372036854775807 WHERE id = 0",
        "UPDATE edges SET id = -4096 WHERE id = 0",
        "UPDATE meta SET value = '18446744073709551615' WHERE name = 'vertices'",
        "UPDATE meta SET value = 'nan' WHERE name = 'plan_cell_m'"}) {
    writeText(path_, sound_);
    execute(sql);
    EXPECT_NE(messageOfLoad(path_).find("damaged map file"), std::string::npos)
        << sql << ": " << messageOfLoad(path_);
  }
}

// ---- files beside a map

/// A journal whose header says this. `records`: as many bytes behind the header as they take.
std::string journalOf(std::uint32_t pages, std::uint32_t page_bytes, const std::string& records,
                      std::uint32_t count) {
  const auto number = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xFF);
    return bytes;
  };
  std::string journal = "\xD9\xD5\x05\xF9\x20\xA1\x63\xD7" + number(count) + number(7) +
                        number(pages) + number(512) + number(page_bytes);
  journal.resize(512);
  return journal + records;
}

/// The end of a journal that names a file for SQLite to delete.
std::string nameOf(const std::string& file) {
  std::uint32_t sum = 0;
  for (const char c : file) sum += static_cast<std::uint8_t>(c);
  const auto low = [](std::size_t value) {
    return std::string({0, 0, static_cast<char>(value >> 8), static_cast<char>(value & 0xFF)});
  };
  return low(0) + file + low(file.size()) + low(sum) + "\xD9\xD5\x05\xF9\x20\xA1\x63\xD7";
}

TEST_F(DamagedMap, AJournalThatIsNotOfThisMapIsNotUsed) {
  const std::string journal = path_ + "-journal", victim = folder_ / "precious.txt";
  const auto pages = static_cast<std::uint32_t>(sound_.size() / 4096);
  const std::string page = std::string(3, '\0') + '\1' + std::string(4096 + 4, '\0');
  const std::string unused = std::string(12, '\0') + journalOf(pages, 4096, "", 0).substr(12);
  const std::pair<std::string, const char*> cases[] = {
      {journalOf(pages, 4096, nameOf(victim), 0), "names another file"},
      {unused + nameOf(victim), "names another file"},
      {journalOf(1, 4096, "", 0), "is of a map of 1 pages"},
      {journalOf(1, 4096, page, 1), "is of a map of 1 pages"},
      {journalOf(pages + 1, 4096, "", 0), "this one has"},
      {journalOf(pages, 512, "", 0), "has pages of 512 bytes"},
      {"my thesis", "does not begin as a journal does"},
      {std::string(5000, '\0'), "has pages of 0 bytes"}};
  writeText(victim, "my thesis");
  for (const auto& [bytes, expected] : cases) {
    writeText(journal, bytes);
    const std::string messages[] = {messageOfLoad(path_),
                                    messageOf([&] { saveMap(path_, map_); }),
                                    messageOf([&] { saveRevision(path_, map_, "", nullptr); }),
                                    messageOf([&] { undoRevision(path_); }),
                                    messageOf([&] { readRevisions(path_); }),
                                    messageOf([&] { replaceMap(path_, path_); })};
    for (const std::string& message : messages) {
      EXPECT_NE(message.find(expected), std::string::npos) << expected << ": " << message;
      EXPECT_NE(message.find(journal), std::string::npos) << message;
    }
    EXPECT_EQ(readText(journal), bytes);
    EXPECT_EQ(readText(path_), sound_);
    EXPECT_TRUE(fs::exists(victim));
  }
  fs::remove(journal);
  fs::create_symlink(victim, journal);
  EXPECT_NE(messageOfLoad(path_).find("is no regular file"), std::string::npos);
  EXPECT_TRUE(fs::exists(victim));
}

/// Pages are numbered from 1: a hole in a file has no records, however large it is.
TEST_F(DamagedMap, AJournalOfNothingEndsAtOnce) {
  const auto pages = static_cast<std::uint32_t>(sound_.size() / 4096);
  std::string header = journalOf(pages, 4096, "", 0xFFFFFFFF);
  header.replace(12, 4, std::string(4, '\0'));  // so that the sums of zeros are right
  writeText(path_ + "-journal", header);
  fs::resize_file(path_ + "-journal", std::uintmax_t{1} << 40);
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), map_));
}

TEST_F(DamagedMap, AJournalThroughALinkToTheMapIsSeen) {
  const std::string link = folder_ / "link.xvm";
  fs::create_symlink(path_, link);
  writeText(path_ + "-journal", journalOf(1, 4096, "", 0));
  EXPECT_NE(messageOfLoad(link).find("town.xvm-journal: "), std::string::npos);
}

TEST_F(DamagedMap, AWriteAheadLogBesideAMapIsRefusedAndNothingIsMade) {
  writeText(path_ + "-wal", std::string(5000, 'w'));
  EXPECT_NE(messageOfLoad(path_).find("town.xvm-wal: is a write-ahead log"), std::string::npos);
  EXPECT_NE(messageOf([&] { saveMap(path_, map_); }).find("town.xvm-wal"), std::string::npos);
  EXPECT_FALSE(fs::exists(path_ + "-shm"));
}

TEST_F(DamagedMap, AJournalOfAFormerMapDoesNotGetIntoANewOne) {
  const std::string fresh = folder_ / "fresh.xvm";
  writeText(fresh + "-journal", journalOf(3, 4096, "", 0));
  EXPECT_NE(messageOf([&] { saveMap(fresh, map_); }).find("would change the new map"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(fresh));
}

}  // namespace
}  // namespace xview::map
