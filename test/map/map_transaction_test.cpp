// SPDX-License-Identifier: BSD-3-Clause
// Changes of a map file happen whole or not at all.
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "map/contents.h"
#include "map/sample_map.h"
#include "place/edges.h"
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

std::size_t filesIn(const std::string& folder) {
  const auto files = fs::directory_iterator(folder);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

/// Runs an action in a child process and returns its exit code; 128 + n if signal n ended it.
template <class Action>
int inChild(Action&& action) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      action();
    } catch (const Error&) {
      _exit(1);
    } catch (...) {
      _exit(2);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

class MapTransaction : public ::testing::Test {
 protected:
  void SetUp() override {
    saveMap(path_, sampleMap(1));
    old_ = unpacked(openMap(path_));
    const TemporaryFolder other;
    saveMap(other / "new.xvm", sampleMap(2));
    new_ = unpacked(openMap(other / "new.xvm"));
  }

  /// Of the changes that can be undone, oldest first.
  std::vector<std::string> notesOfRevisions() const {
    SQLite::Database database(path_);
    std::vector<std::string> notes;
    if (!database.tableExists("undo_steps")) return notes;
    SQLite::Statement query(database, "SELECT note FROM undo_steps ORDER BY step");
    while (query.executeStep()) notes.push_back(query.getColumn(0).getString());
    return notes;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "town.xvm";
  SemanticMap old_, new_;
};

TEST_F(MapTransaction, KilledWriterLeavesTheOldMapOrTheNewOne) {
  bool saw_old = false;
  for (useconds_t delay_us = 0; delay_us < 60000; delay_us += 3000) {
    const pid_t child = fork();
    if (child == 0) {
      for (;;) {
        saveMap(path_, new_);
        saveMap(path_, old_);
      }
    }
    usleep(delay_us);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const SemanticMap found = unpacked(openMap(path_));
    saw_old = saw_old || isSame(found, old_);
    EXPECT_TRUE(isSame(found, old_) || isSame(found, new_)) << delay_us;
  }
  EXPECT_TRUE(saw_old);
}

TEST_F(MapTransaction, KilledWriterLeavesNoNewMap) {
  const std::string path = folder_ / "fresh.xvm";
  int without = 0, with = 0;
  useconds_t delay_us = 0;
  // Killed later and later, until a writer has come to its end, however slow the machine is.
  for (int attempt = 0; attempt < 32 && (without == 0 || with == 0); ++attempt) {
    const pid_t child = fork();
    if (child == 0) {
      saveMap(path, new_);
      _exit(0);
    }
    usleep(delay_us);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (!fs::exists(path)) {
      ++without;
      delay_us += 500 + delay_us / 4;
      continue;
    }
    ++with;
    EXPECT_TRUE(isSame(unpacked(openMap(path)), new_)) << delay_us;
    fs::remove(path);
  }
  EXPECT_GT(without, 0) << "no writer was killed before its end";
  EXPECT_GT(with, 0) << "no writer came to its end";
}

/// Ends the process in the middle of a change that has reached the file already.
void dieWhileChanging(const std::string& path) {
  SQLite::Database database(path, SQLite::OPEN_READWRITE);
  database.exec(
      "PRAGMA cache_size = 1; BEGIN IMMEDIATE; DELETE FROM cloud_tiles; UPDATE vertices SET data = "
      "zeroblob(5000);"
      "UPDATE plan_tiles SET data = zeroblob(5000)");
  _exit(0);
}

TEST_F(MapTransaction, UnfinishedChangeIsRolledBackByTheNextReader) {
  inChild([&] { dieWhileChanging(path_); });
  ASSERT_TRUE(fs::exists(path_ + "-journal"));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  EXPECT_EQ(filesIn(folder_.path()), 1u);
}

TEST_F(MapTransaction, UnfinishedChangeIsRolledBackByTheNextWriter) {
  inChild([&] { dieWhileChanging(path_); });
  saveMap(path_, sampleMap(2));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), new_));
}

TEST_F(MapTransaction, FullDiskLeavesTheOldMap) {
  const std::string before = readText(path_);
  const int code = inChild([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{before.size() + 8192, before.size() + 8192};
    setrlimit(RLIMIT_FSIZE, &limit);
    SemanticMap larger = sampleMap(2);
    larger.graph.vertices.resize(20000);
    larger.graph.neighbours.resize(20000);
    saveMap(path_, larger);
  });
  EXPECT_EQ(code, 1);
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  EXPECT_EQ(filesIn(folder_.path()), 1u);
}

TEST_F(MapTransaction, FullDiskLeavesNoNewFile) {
  const int code = inChild([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    setrlimit(RLIMIT_FSIZE, &limit);
    saveMap(folder_ / "fresh.xvm", new_);
  });
  EXPECT_EQ(code, 1);
  EXPECT_EQ(filesIn(folder_.path()), 1u);
}

TEST_F(MapTransaction, FolderThatDoesNotExistIsAnError) {
  EXPECT_THROW(saveMap(folder_ / "no/such/town.xvm", new_), Error);
  EXPECT_THROW(saveMap("/proc/town.xvm", new_), Error);
}

TEST_F(MapTransaction, DeviceIsNotReplaced) {
  EXPECT_THROW(saveMap("/dev/full", new_), Error);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

/// Runs as a user without privileges; root may write everywhere.
template <class Action>
int inChildWithoutPrivileges(Action&& action) {
  return inChild([&] {
    if (getuid() == 0 && setuid(65534) != 0) _exit(3);
    action();
  });
}

TEST_F(MapTransaction, ReadOnlyMapInAReadOnlyFolderLoads) {
  chmod(path_.c_str(), 0444);
  chmod(folder_.path().c_str(), 0555);
  const int code = inChildWithoutPrivileges([&] {
    if (!isSame(unpacked(openMap(path_)), old_)) _exit(4);
  });
  chmod(folder_.path().c_str(), 0755);
  EXPECT_EQ(code, 0);
  EXPECT_EQ(filesIn(folder_.path()), 1u);
}

TEST_F(MapTransaction, ReadOnlyMapIsNotChanged) {
  saveRevision(path_, old_, "nothing new");
  const std::string before = readText(path_);
  chmod(path_.c_str(), 0444);
  chmod(folder_.path().c_str(), 0555);
  EXPECT_EQ(inChildWithoutPrivileges([&] { saveMap(path_, new_); }), 1);
  EXPECT_EQ(inChildWithoutPrivileges([&] { saveRevision(path_, new_, ""); }), 1);
  EXPECT_EQ(inChildWithoutPrivileges([&] { undoRevision(path_); }), 1);
  EXPECT_EQ(inChildWithoutPrivileges([&] { saveMap(folder_ / "fresh.xvm", new_); }), 1);
  chmod(folder_.path().c_str(), 0755);
  EXPECT_EQ(readText(path_), before);
  EXPECT_EQ(filesIn(folder_.path()), 1u);
}

TEST_F(MapTransaction, RevisionCanBeTakenBack) {
  const auto size = fs::file_size(path_);
  saveRevision(path_, new_, "fused rear 30-59");
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), new_));
  EXPECT_EQ(notesOfRevisions(), std::vector<std::string>{"fused rear 30-59"});
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  EXPECT_TRUE(notesOfRevisions().empty());
  EXPECT_EQ(fs::file_size(path_), size);
  EXPECT_FALSE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
}

TEST_F(MapTransaction, RevisionsAreTakenBackOneByOne) {
  saveRevision(path_, new_, "first");
  saveRevision(path_, SemanticMap(), "second");
  saveRevision(path_, old_, "third");
  EXPECT_EQ(notesOfRevisions(), (std::vector<std::string>{"first", "second", "third"}));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), SemanticMap()));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), new_));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  EXPECT_FALSE(undoRevision(path_));
}

TEST_F(MapTransaction, WhatWasAddedIsKeptApartUntilItIsTakenBack) {
  Visit visit{new_, 0.25};
  saveRevision(path_, new_, "added", &visit);
  saveRevision(path_, old_, "changed");
  const std::vector<Revision> revisions = readRevisions(path_);
  ASSERT_EQ(revisions.size(), 2u);
  EXPECT_EQ(revisions[0].note, "added");
  EXPECT_TRUE(revisions[0].is_visit);
  EXPECT_FALSE(revisions[1].is_visit);
  const Visit loaded = loadVisit(path_, 0);
  EXPECT_TRUE(isSame(loaded.place, new_));
  EXPECT_EQ(loaded.sigma_m, 0.25);
  EXPECT_THROW(loadVisit(path_, 1), Error);
  EXPECT_THROW(loadVisit(path_, 2), Error);
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(readRevisions(path_).empty());
  EXPECT_THROW(loadVisit(path_, 0), Error);
}

TEST_F(MapTransaction, AMapIsReplacedWithItsRecord) {
  const std::string other = folder_ / "other.xvm";
  saveMap(other, old_);
  const Visit visit{new_, 0};
  saveRevision(other, new_, "added", &visit);
  replaceMap(path_, other);
  EXPECT_EQ(readText(path_).size(), readText(other).size());
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), new_));
  ASSERT_EQ(readRevisions(path_).size(), 1u);
  EXPECT_TRUE(isSame(loadVisit(path_, 0).place, new_));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  std::ofstream(other) << "no map";
  EXPECT_THROW(replaceMap(path_, other), Error);
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
}

TEST_F(MapTransaction, SavingForgetsTheRevisions) {
  saveRevision(path_, new_, "first");
  saveMap(path_, old_);
  EXPECT_TRUE(notesOfRevisions().empty());
  EXPECT_FALSE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
}

TEST_F(MapTransaction, RevisionStoresOnlyWhatChanges) {
  const auto before = fs::file_size(path_);
  SemanticMap map = old_;
  map.graph.vertices[0].observations += 1;
  saveRevision(path_, map, "one more observation");
  EXPECT_LT(fs::file_size(path_), before + 16 * 4096);  // a page for each new table
}

/// Blocks of vertices that were not changed are those of the file.
TEST_F(MapTransaction, AMapThatWasPackedIsWrittenAsOneThatWasLoaded) {
  SemanticMap large = old_;
  const Vertex model = large.graph.vertices.at(0);
  for (int i = 0; i < 3000; ++i) {
    large.graph.vertices.push_back(model);
    large.graph.vertices.back().position.x() += i;
  }
  large.size = kTownScale;
  useRadius(large.graph, {});
  saveMap(path_, large);
  for (const int change : {0, 1, 2, 3}) {
    SemanticMap grown = openMap(path_), loaded = unpacked(openMap(path_));
    unpackVertices(grown);
    ASSERT_NE(grown.packed_vertices, nullptr);
    for (SemanticMap* map : {&grown, &loaded}) {
      auto& vertices = map->graph.vertices;
      if (change == 1) vertices[1500].sigma_m += 1;
      if (change == 2) vertices[1500].last_frame += 1;
      if (change == 3) vertices.push_back(model);
    }
    saveMap(folder_ / "grown.xvm", grown);
    saveMap(folder_ / "loaded.xvm", loaded);
    EXPECT_EQ(readText(folder_ / "grown.xvm"), readText(folder_ / "loaded.xvm")) << change;
    fs::remove(folder_ / "grown.xvm");
    fs::remove(folder_ / "loaded.xvm");
  }
}

TEST_F(MapTransaction, SeveralChangesAreMadeTogetherOrNotAtAll) {
  const std::string before = readText(path_);
  const Visit visit{new_, 0.5};
  {
    MapChanges changes(path_);
    changes.add(new_, "first", &visit);
    changes.add(SemanticMap(), "second");
    EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_)) << "others see it when it is done";
  }
  EXPECT_EQ(readText(path_), before);
  EXPECT_EQ(filesIn(folder_.path()), 1u);

  MapChanges changes(path_);
  changes.add(new_, "first", &visit);
  changes.add(SemanticMap(), "second");
  changes.commit();
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), SemanticMap()));
  EXPECT_EQ(notesOfRevisions(), (std::vector<std::string>{"first", "second"}));
  EXPECT_TRUE(isSame(loadVisit(path_, 0).place, new_));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), new_));
  EXPECT_TRUE(undoRevision(path_));
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));

  MapChanges(path_).commit();  // of nothing
  EXPECT_TRUE(isSame(unpacked(openMap(path_)), old_));
  EXPECT_THROW(MapChanges(folder_ / "none.xvm"), Error);
}

TEST_F(MapTransaction, RevisionNeedsAMap) {
  EXPECT_THROW(saveRevision(folder_ / "none.xvm", new_, ""), Error);
}

}  // namespace
}  // namespace xview::map
