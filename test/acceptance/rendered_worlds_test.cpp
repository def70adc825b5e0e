// SPDX-License-Identifier: BSD-3-Clause
// Rendered worlds with labels of a network, stereo depth and odometry that drifts: what is found
// there, what is refused, and what is made of it.
#include <gtest/gtest.h>

#include <filesystem>

#include "acceptance/answers.h"
#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

/// A map of the forward drive of a recorded world, made once for all tests of the world.
class RenderedWorld {
 public:
  explicit RenderedWorld(const std::string& world) : world_(world) {
    outputOf({"map", "--quiet", session("forward"), map()});
  }
  std::string session(const std::string& name) const { return world_ + "/" + name; }
  std::string map() const { return file("world.xvm"); }
  std::string file(const std::string& name) const { return folder_ / name; }
  std::vector<Eigen::Vector3d> truth(const std::string& name) const {
    return positionsIn(session(name) + "/groundtruth.txt");
  }

 private:
  TemporaryFolder folder_;
  std::string world_;
};

/// Frames are 2 m apart in all worlds, so 30 of them are 60 m.
std::vector<std::string> windowsOf60m(const std::string& session, const std::string& map,
                                      const std::string& stride) {
  return {session, "--window", "30", "--stride", stride, map};
}

template <const char* const& kFolder>
class WorldTest : public testing::Test {
 protected:
  void SetUp() override {
    XVIEW_REQUIRE_DATA(folder, kFolder);
    if (!world_) world_ = new RenderedWorld(folder);
  }
  static void TearDownTestSuite() {
    delete world_;
    world_ = nullptr;
  }
  static RenderedWorld* world_;
};
template <const char* const& kFolder>
RenderedWorld* WorldTest<kFolder>::world_ = nullptr;

constexpr const char* kSuburb = "suburb_noisy";
constexpr const char* kGrid = "grid_noisy";
using NoisySuburb = WorldTest<kSuburb>;
using NoisyGrid = WorldTest<kGrid>;

TEST_F(NoisySuburb, TheWayBackIsFoundWithinHalfAMetre) {
  const std::string answers = localize(windowsOf60m(world_->session("rear"), world_->map(), "15"));
  const Tally tally = tallyOf(answers, world_->truth("rear"), 0.5);
  EXPECT_EQ(tally.windows, 7u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 6u) << tally.reasons;
}

TEST_F(NoisySuburb, AFlightIsFoundWithinAMetre) {
  const std::string answers =
      localize(windowsOf60m(world_->session("aerial"), world_->map(), "20"));
  const Tally tally = tallyOf(answers, world_->truth("aerial"), 1);
  EXPECT_EQ(tally.windows, 5u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 4u) << tally.reasons;
}

TEST_F(NoisySuburb, AnotherWorldIsRefusedAndTheReportCountsIt) {
  const std::string negatives =
      localize(windowsOf60m(world_->session("elsewhere"), world_->map(), "10"));
  const Tally tally = tallyOfNegatives(negatives);
  EXPECT_EQ(tally.windows, 4u);
  EXPECT_EQ(tally.accepted, 0u) << tally.reasons;

  writeText(world_->file("elsewhere.jsonl"), negatives);
  writeText(world_->file("oblique.jsonl"),
            localize(windowsOf60m(world_->session("oblique"), world_->map(), "60")));
  const std::string report = world_->file("report");
  outputOf({"evaluate", "--quiet", world_->file("oblique.jsonl"),
            world_->session("oblique") + "/groundtruth.txt", "--negatives",
            world_->file("elsewhere.jsonl"), "--map", world_->map(), "-o", report});
  const Json summary = Json::parse(readText(report + "/summary.json"));
  EXPECT_EQ(summary["negatives"].get<int>(), 4);
  EXPECT_EQ(summary["false_accepts"].get<int>(), 0);
  EXPECT_GT(fs::file_size(report + "/report.html"), 10000u);
}

TEST_F(NoisySuburb, ThreadsDoNotChangeAByteOfTheAnswers) {
  const auto answersWith = [&](const std::string& threads) {
    return withoutTimes(localize({world_->session("rear"), world_->session("elsewhere"), "--window",
                                  "30", "--stride", "60", "--threads", threads, world_->map()}));
  };
  const std::string one = answersWith("1");
  EXPECT_EQ(lineCount(one), 3u);
  EXPECT_EQ(one, answersWith("2"));
}

TEST_F(NoisySuburb, AFusedDriveIsInTheMapUntilItIsTakenBack) {
  const std::string grown = world_->file("grown.xvm");
  fs::copy_file(world_->map(), grown);
  const auto content = [&] { return outputOf({"info", grown}); };
  const auto answers = [&] {
    return withoutTimes(localize(windowsOf60m(world_->session("oblique"), grown, "60")));
  };
  const std::string content_before = content(), answers_before = answers();
  outputOf({"fuse", "--quiet", world_->session("rear"), "--frames", "40:100", grown});
  EXPECT_NE(content(), content_before);
  const Tally tally = tallyOf(answers(), world_->truth("oblique"), 0.5);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 1u) << tally.reasons;
  outputOf({"fuse", "--quiet", "--undo", grown});
  EXPECT_EQ(content(), content_before);
  EXPECT_EQ(answers(), answers_before);
}

TEST_F(NoisySuburb, DrawingsShowMapAndQueriesAndCanBeRead) {
  const std::string answers = world_->file("drawn.jsonl");
  writeText(answers, localize(windowsOf60m(world_->session("rear"), world_->map(), "60")));
  const auto drawn = [&](const std::string& name) {
    outputOf({"view", "--quiet", world_->map(), answers, world_->file(name)});
    return world_->file(name);
  };
  EXPECT_EQ(readText(drawn("drawn.png")).substr(1, 3), "PNG");
  EXPECT_NE(readText(drawn("drawn.html")).find("</html>"), std::string::npos);
  const MeshSize scene = sizeOfMesh(drawn("drawn.ply"));
  EXPECT_GT(scene.vertices, 1000u);
  EXPECT_GT(scene.faces, 1000u);

  outputOf({"match", "--quiet", world_->session("rear"), "--frames", "30:60", world_->map(),
            world_->file("match.ply")});
  EXPECT_GT(sizeOfMesh(world_->file("match.ply")).faces, scene.faces)
      << "the map, the query and what ties them are more than the map";
}

TEST_F(NoisyGrid, StreetsThatLookAlikeAreNotTakenForEachOther) {
  const Tally negatives =
      tallyOfNegatives(localize(windowsOf60m(world_->session("elsewhere"), world_->map(), "30")));
  EXPECT_EQ(negatives.windows, 4u);
  EXPECT_EQ(negatives.accepted, 0u) << negatives.reasons;

  const Tally tally = tallyOf(localize(windowsOf60m(world_->session("rear"), world_->map(), "30")),
                              world_->truth("rear"), 0.6);
  EXPECT_EQ(tally.windows, 4u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 3u) << tally.reasons;
}

}  // namespace
}  // namespace xview::test
