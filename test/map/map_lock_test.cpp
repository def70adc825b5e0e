// SPDX-License-Identifier: BSD-3-Clause
#include "xview/map/semantic_map.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "map/sample_map.h"
#include "support/test_data.h"

namespace xview::map {
namespace {

TEST(MapLock, TheSecondWaitsForTheFirst) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "town.xvm";
  saveMap(path, test::sampleMap());
  auto first = std::make_unique<MapLock>(path);
  std::atomic<bool> has_second{false};
  std::thread other([&] {
    const MapLock second(path);
    has_second = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(has_second);
  first.reset();
  other.join();
  EXPECT_TRUE(has_second);
}

TEST(MapLock, ItsHolderReadsAndWrites) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "town.xvm";
  saveMap(path, test::sampleMap());
  const MapLock lock(path);
  const SemanticMap map = unpacked(openMap(path));
  saveRevision(path, map, "again");
  EXPECT_TRUE(undoRevision(path));
}

TEST(MapLock, AMapThatIsNotThereIsNotHeld) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "none.xvm";
  const MapLock first(path), second(path);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "a lock makes no map";
  saveMap(path, test::sampleMap());
  const MapLock third(path);  // would wait for ever if one of the others held it
  EXPECT_TRUE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace xview::map
