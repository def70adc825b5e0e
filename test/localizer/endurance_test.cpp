// SPDX-License-Identifier: BSD-3-Clause
// What a program that runs for days does again and again.
#include <gtest/gtest.h>
#include <fstream>
#include <thread>

#include "base/random.h"
#include "localizer/simulated_drive.h"
#include "support/memory.h"
#include "support/nightly.h"
#include "support/sanitizers.h"
#include "support/test_data.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"

namespace xview {
namespace {

using test::isNightly;
using test::resident_mb;
using test::simulatedDrive;

constexpr double kFlat_mb = 16;  ///< what caches and the heap may still grow after a warm-up

SemanticGraph scattered(std::size_t count, double side_m) {
  SemanticGraph graph;
  Random random(7);
  for (std::size_t i = 0; i < count; ++i) {
    Vertex v;
    v.label = 1 + random.below(5);
    v.position = {random.uniform(0, side_m), random.uniform(0, side_m), 0};
    graph.vertices.push_back(v);
  }
  return graph;
}

void expectSame(const Localization& a, const Localization& b) {
  ASSERT_EQ(a.status, b.status);
  ASSERT_EQ(a.confidence, b.confidence);
  ASSERT_EQ(a.T_map_query.matrix(), b.T_map_query.matrix());
  ASSERT_EQ(a.covariance, b.covariance);
}

/// Calls once(), then `count` times more; the memory must not grow by then.
template <class Once>
void expectFlat(int count, const Once& once) {
  const int warm_up = std::max(1, count / 20);
  for (int i = 0; i < warm_up; ++i) once();
  const double before_mb = resident_mb();
  for (int i = 0; i < count; ++i) once();
  if (!test::kSanitized) {
    EXPECT_LT(resident_mb() - before_mb, kFlat_mb) << count << " times";
  }
}

TEST(Endurance, AnswersOfGraphsStayEqualAndMemoryFlat) {
  const LabelSet labels = genericLabelSet({1, 2, 3, 4, 5});
  const SemanticGraph all = scattered(300, 250);
  SemanticGraph part;
  for (const Vertex& v : all.vertices) {
    if ((v.position.head<2>() - Eigen::Vector2d(120, 110)).norm() < 50) part.vertices.push_back(v);
  }
  const Localizer localizer(buildMap(all, labels, "objects", {}));
  const Query query = makeQuery(part, labels, {});
  const Localization first = localizer.localize(query);
  EXPECT_EQ(first.status, Status::accepted);
  expectFlat(isNightly() ? 10000 : 20, [&] { expectSame(localizer.localize(query), first); });
}

TEST(Endurance, AnswersOfViewsStayEqualAndMemoryFlat) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const Query query = drive.query("rear", 10, 40);
  const Localization first = localizer.localize(query);
  EXPECT_EQ(first.status, Status::accepted);
  expectFlat(isNightly() ? 500 : 1, [&] { expectSame(localizer.localize(query), first); });
}

TEST(Endurance, SixteenCallersGetTheAnswersOfOne) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const Query rear = drive.query("rear", 10, 40), elsewhere = drive.query("elsewhere", 0, 20);
  const Localization of_rear = Localizer(drive.map).localize(rear),
                     of_elsewhere = Localizer(drive.map).localize(elsewhere);
  std::vector<Localization> answers(16);
  std::vector<std::thread> callers;
  for (std::size_t i = 0; i < answers.size(); ++i)
    callers.emplace_back([&, i] { answers[i] = localizer.localize(i % 2 ? rear : elsewhere); });
  for (std::thread& caller : callers) caller.join();
  for (std::size_t i = 0; i < answers.size(); ++i)
    expectSame(answers[i], i % 2 ? of_rear : of_elsewhere);
}

/// Appends to a map and takes that back, again and again; its content stays what it was, its file
/// does not grow.
void appendAndUndo(const map::SemanticMap& town, const map::SemanticMap& addition, int count) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "town.xvm";
  const auto content = [&] {
    const std::string fresh = folder / "fresh.xvm";
    std::filesystem::remove(fresh);
    map::saveMap(fresh, map::openMap(path));
    return test::readText(fresh);
  };
  map::saveMap(path, town);
  const std::string before = content();
  std::uintmax_t size = 0;
  const auto once = [&] {
    map::SemanticMap grown = map::openMap(path);
    appendToMap(grown, addition, {});
    map::saveRevision(path, grown, "append");
    ASSERT_TRUE(map::undoRevision(path));
    if (size == 0) size = std::filesystem::file_size(path);
  };
  expectFlat(count, once);
  EXPECT_TRUE(content() == before);
  EXPECT_LE(std::filesystem::file_size(path), size);
}

TEST(Endurance, AdditionsToGraphsThatAreTakenBackLeaveNothing) {
  const LabelSet labels = genericLabelSet({1, 2, 3, 4, 5});
  appendAndUndo(buildMap(scattered(300, 250), labels, "objects", {}),
                buildMap(scattered(40, 100), labels, "others", {}), isNightly() ? 1000 : 10);
}

TEST(Endurance, AdditionsOfDrivesThatAreTakenBackLeaveNothing) {
  const auto& drive = simulatedDrive();
  appendAndUndo(drive.map, buildMap(*drive.sessions.at("rear"), {}), isNightly() ? 50 : 1);
}

}  // namespace
}  // namespace xview
