// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "compare/self_similarity.h"
#include "localizer/helper.h"
#include "localizer/simulated_drive.h"
#include "map/contents.h"
#include "support/helpers_in_one_process.h"
#include "support/test_data.h"
#include "verdict/verdict.h"
#include "xview/base/error.h"
#include "xview/cloud_recording.h"
#include "xview/localizer.h"

namespace xview {
namespace {

using test::simulatedDrive;

TEST(Mapper, AMapHoldsGraphBevCloudAndPoses) {
  const map::SemanticMap& map = simulatedDrive().map;
  EXPECT_TRUE(isConsistent(map.graph));
  EXPECT_GT(map.graph.size(), 100u);
  EXPECT_GT(map.bev.sampleCount(), 1000u);
  EXPECT_GT(map.cloud.size(), 10000u);
  EXPECT_GT(map.poses.size(), 30u);
  EXPECT_EQ(map.sources.size(), 1u);
  EXPECT_FALSE(map.bev.aerial);
}

TEST(Mapper, ThreadsDoNotChangeTheMap) {
  Options one, two;
  one.threads = 1;
  two.threads = 2;
  const FrameSource* forward = simulatedDrive().sessions.at("forward").get();
  const map::SemanticMap a = buildMap({forward}, one), b = buildMap({forward}, two);
  ASSERT_EQ(a.graph.size(), b.graph.size());
  for (std::size_t i = 0; i < a.graph.size(); ++i)
    EXPECT_EQ(a.graph.vertices[i].position, b.graph.vertices[i].position);
  EXPECT_EQ(a.bev.sampleCount(), b.bev.sampleCount());
  EXPECT_EQ(a.cloud.size(), b.cloud.size());
}

void expectSameGraph(const SemanticGraph& a, const SemanticGraph& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.neighbours, b.neighbours);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.vertices[i].label, b.vertices[i].label);
    EXPECT_EQ(a.vertices[i].position, b.vertices[i].position);
  }
}

TEST(Mapper, TheGraphOfARecordingIsThatOfItsMapAndOfAQueryOfAllOfIt) {
  const auto& drive = simulatedDrive();
  for (const char* session : {"forward", "rear"}) {
    const FrameSource& source = *drive.sessions.at(session);
    const SemanticGraph graph = makeQuery(source, {}).graph;
    expectSameGraph(graph, buildMap({&source}, {}).graph);
    expectSameGraph(graph, drive.query(session, 0, source.size()).graph);
  }
}

TEST(Mapper, TheGraphOfATiltedRecordingIsThatOfItsMap) {
  const Eigen::Isometry3d tilt(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 0).normalized()));
  const PosedRecording tilted(*simulatedDrive().sessions.at("rear"), tilt);
  const SemanticGraph graph = makeQuery(tilted, {}).graph;
  EXPECT_GT(graph.size(), 100u);
  expectSameGraph(graph, buildMap({&tilted}, {}).graph);
}

TEST(Mapper, FramesAreSeenInOrderWhileAPlaceIsMade) {
  const FrameSource& source = *simulatedDrive().sessions.at("rear");
  std::vector<std::int64_t> seen, expected;
  makeQuery(source, {}, [&](const PreprocessedFrame& frame) { seen.push_back(frame.number); });
  for (std::size_t i = 0; i < source.size(); ++i) expected.push_back(source.number(i));
  EXPECT_EQ(seen, expected);
}

TEST(Mapper, FramesOneByOneAreThoseAllAtOnce) {
  const auto& drive = simulatedDrive();
  const std::vector<PreprocessedFrame>& all = drive.frames.at("rear");
  std::size_t i = 0;
  preprocessRecording(*drive.sessions.at("rear"), {}, [&](PreprocessedFrame frame) {
    ASSERT_LT(i, all.size());
    EXPECT_EQ(frame.number, all[i].number);
    EXPECT_EQ(frame.weights, all[i].weights);
    ASSERT_EQ(frame.cloud.size(), all[i].cloud.size());
    EXPECT_EQ(frame.blobs.size(), all[i].blobs.size());
    ++i;
  });
  EXPECT_EQ(i, all.size());
}

/// What another process has opened itself.
std::unique_ptr<FrameSource> reopened(const FrameSource& source) {
  return std::make_unique<PosedRecording>(source, Eigen::Isometry3d::Identity());
}

class HelpedMapper : public testing::Test {
 protected:
  HelpedMapper() {
    for (const PreprocessedFrame& frame : drive_.frames.at("rear")) {
      const Eigen::Isometry3d pose(Eigen::Translation3d(frame.cloud.origin));
      scans_.add(frame.cloud.points, pose);
      if (raw_.size() < 12) raw_.add(frame.cloud.points, pose);
    }
  }

  /// The bytes of its file.
  std::string visitOf(const std::vector<const FrameSource*>& sources, const Options& options) {
    map::saveMap(folder_ / "map.xvm", buildVisit(sources, options));
    return test::readText(folder_ / "map.xvm");
  }
  void expectSame(const std::vector<const FrameSource*>& sources, const Options& options,
                  int count) {
    const std::string alone = visitOf(sources, options);
    const auto open = [&] {
      RecordingsOfMap recordings{{}, options};
      for (const FrameSource* source : sources) recordings.sources.push_back(reopened(*source));
      return recordings;
    };
    test::HelpersInOneProcess<Helper> helpers(count, open);
    const SharedRecordings shared(sources);
    EXPECT_TRUE(visitOf(sources, options) == alone) << "helpers: " << count;
    EXPECT_FALSE(helpers.isWaitedFor());
    std::size_t asked = 0, frames = 0;
    for (int i = 0; i < count; ++i) asked += helpers.answersOf(i);
    for (const FrameSource* source : sources) frames += source->size();
    EXPECT_EQ(asked, frames);
  }

  const test::SimulatedDrive& drive_ = simulatedDrive();
  const FrameSource& images_ = *drive_.sessions.at("rear");
  CloudRecording scans_{drive_.labels}, raw_;
  test::TemporaryFolder folder_;
};

TEST_F(HelpedMapper, MakesTheSameMap) {
  Options in_images;
  in_images.graph_space = "image";
  expectSame({&images_, &scans_}, {}, 3);
  expectSame({&images_}, in_images, 300);
  expectSame({&raw_}, {}, 1);
}

TEST_F(HelpedMapper, AsksNobodyForRecordingsThatHelpersDoNotHave) {
  test::HelpersInOneProcess<Helper> helpers(2);
  const SharedRecordings shared({&images_});
  EXPECT_NO_THROW(visitOf({&scans_}, {}));
  EXPECT_EQ(helpers.answersOf(0) + helpers.answersOf(1), 0);
  EXPECT_THROW(visitOf({&images_}, {}), UsageError) << "which were promised";
}

TEST(Helper, RefusesWhatIsNoRequest) {
  Helper helper;
  for (const std::string& text : {std::string(), std::string("hello, how are you?"),
                                  std::string(20, '\0'), std::string(20, '\1')})
    EXPECT_THROW(helper.answer(text), Error);
}

/// A helper that cannot do what it is asked for.
struct BrokenHelper {
  std::string answer(const std::string&) const { throw Error("frame 7", "broken"); }
};

TEST_F(HelpedMapper, EndsWithWhatAHelperCannotDo) {
  test::HelpersInOneProcess<BrokenHelper> helpers(2);
  const SharedRecordings shared({&images_});
  EXPECT_EQ(test::messageOf<Error>([&] { visitOf({&images_}, {}); }), "frame 7: broken");
  EXPECT_FALSE(helpers.isWaitedFor());
}

TEST(Mapper, AppendingTheSameDriveAddsPosesButHardlyVertices) {
  map::SemanticMap map = simulatedDrive().map;
  const map::SemanticMap again = map;
  appendToMap(map, again, {});
  EXPECT_TRUE(isConsistent(map.graph));
  EXPECT_EQ(map.poses.size(), 2 * again.poses.size());
  EXPECT_EQ(map.source_of_pose.back(), 1u);
  EXPECT_LT(map.graph.size(), again.graph.size() + again.graph.size() / 20);
  EXPECT_EQ(map.bev.known.size(), again.bev.known.size());
}

/// Points that are unpacked where they are asked for are those that are unpacked at once, and those
/// of the map before it was saved.
TEST(Mapper, APackedMapAnswersAsAWholeOne) {
  const auto& drive = simulatedDrive();
  const test::TemporaryFolder folder;
  map::saveMap(folder / "map.xvm", drive.map);
  const Query query = drive.query("rear", 10, 40);
  const Localization packed = Localizer(map::openMap(folder / "map.xvm")).localize(query),
                     whole =
                         Localizer(map::unpacked(map::openMap(folder / "map.xvm"))).localize(query),
                     unsaved = Localizer(map::borrowed(drive.map)).localize(query);
  EXPECT_TRUE(packed.accepted()) << packed.reason;
  EXPECT_EQ(packed.T_map_query.matrix(), whole.T_map_query.matrix());
  EXPECT_EQ(packed.confidence, whole.confidence);
  EXPECT_TRUE(unsaved.T_map_query.isApprox(whole.T_map_query, 1e-6));
  EXPECT_NEAR(unsaved.confidence, whole.confidence, 1e-6);
}

/// Check fix for: what a map remembers of its own stretches was judged by the model that the
/// program comes with, whatever the options said.
TEST(Mapper, AMapRemembersItsStretchesWithTheGivenVerdict) {
  const auto& drive = simulatedDrive();
  const test::TemporaryFolder folder;
  verdict::VerdictModel doubting = verdict::defaultVerdictModel();
  doubting.bare[verdict::kConstant] = -50;
  Options options;
  options.verdict.model = folder / "doubting.txt";
  std::ofstream(options.verdict.model) << verdict::toText(doubting);
  const map::SemanticMap map = buildMap({drive.sessions.at("forward").get()}, options);
  ASSERT_FALSE(map.own_stretches.empty());
  for (const map::OwnStretch& stretch : map.own_stretches) EXPECT_LT(stretch.confidence, 1e-6);
}

TEST(Mapper, APackedMapGrowsAsAWholeOne) {
  const auto& drive = simulatedDrive();
  const test::TemporaryFolder folder;
  map::saveMap(folder / "map.xvm", drive.map);
  map::SemanticMap packed = map::openMap(folder / "map.xvm"),
                   whole = map::unpacked(map::openMap(folder / "map.xvm"));
  const std::size_t stretches = packed.own_stretches.size();
  appendToMap(packed, drive.map, {});
  appendToMap(whole, drive.map, {});
  EXPECT_EQ(map::countsOf(packed).points, map::countsOf(whole).points);
  EXPECT_EQ(packed.graph.size(), whole.graph.size());
  EXPECT_GT(packed.own_stretches.size(), stretches);
  EXPECT_LT(packed.own_stretches.size(), 2 * stretches) << "those of before are kept, not asked";
}

/// The drive, and ground far away, with which the map is a large one.
TEST(Mapper, ALargeMapGrowsPackedAsItDoesUnpacked) {
  const auto& drive = simulatedDrive();
  const test::TemporaryFolder folder;
  map::SemanticMap large = drive.map;
  for (std::int32_t i = 0; i < 500; ++i) large.bev.known.push_back({5000 + 64 * i, 5000, 0, true});
  std::sort(large.bev.known.begin(), large.bev.known.end(), InRowOrder());
  large.null.view = map::fingerprintOfView(large);
  map::saveMap(folder / "map.xvm", large);
  const auto& session = *drive.sessions.at("rear");
  const Eigen::Isometry3d T_map_odom = session.truth(0) * session.pose(0).inverse();
  map::SemanticMap unrounded = buildVisit({&session}, {});
  measureNullHypothesis(unrounded, {});
  map::saveMap(folder / "rear.xvm", inFrameOf(large, unrounded, T_map_odom));
  const map::SemanticMap rear = map::unpacked(map::openMap(folder / "rear.xvm"));  // rounded
  map::SemanticMap packed = map::openMap(folder / "map.xvm"),
                   whole = map::unpacked(map::openMap(folder / "map.xvm"));
  const auto fits = evidenceOfOneFrame(packed, rear, {}),
             also = evidenceOfOneFrame(whole, rear, {});
  ASSERT_TRUE(fits && also);
  EXPECT_GT(fits->agreement(), 0.5);
  EXPECT_EQ(fits->score, also->score);
  EXPECT_EQ(fits->nearby, also->nearby);
  const std::size_t stretches = packed.own_stretches.size(), poses = packed.null.poses;
  appendToMap(packed, rear, {});
  appendToMap(whole, rear, {});
  ASSERT_NE(packed.stored_view, nullptr);
  EXPECT_GT(packed.null.poses, poses) << "what was added is counted";
  EXPECT_EQ(packed.null.poses, whole.null.poses);
  EXPECT_EQ(packed.null.view, whole.null.view);
  double counted = 0, otherwise = 0;  // what was added is rounded before it is counted, or after
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (std::size_t bin = 0; bin < packed.null.counts[c].size(); ++bin) {
      counted += whole.null.counts[c][bin];
      otherwise += std::abs(packed.null.counts[c][bin] - whole.null.counts[c][bin]);
    }
  }
  EXPECT_LT(otherwise, 1e-4 * counted);
  EXPECT_GT(packed.own_stretches.size(), stretches);
  EXPECT_EQ(packed.own_stretches.size(), whole.own_stretches.size());
  EXPECT_EQ(packed.wrong_places.size(), whole.wrong_places.size());
  map::saveMap(folder / "packed.xvm", packed);
  map::saveMap(folder / "whole.xvm", whole);
  const map::SemanticMap a = map::unpacked(map::openMap(folder / "packed.xvm")),
                         b = map::unpacked(map::openMap(folder / "whole.xvm"));
  EXPECT_EQ(a.bev.known.size(), b.bev.known.size());
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    EXPECT_TRUE(std::equal(a.bev.samples[c].begin(), a.bev.samples[c].end(),
                           b.bev.samples[c].begin(), b.bev.samples[c].end(),
                           [](const BevSample& p, const BevSample& q) {
                             return p.x == q.x && p.y == q.y && p.z == q.z;
                           }));
  }
  EXPECT_EQ(a.graph.size(), b.graph.size());
  EXPECT_NE(map::openMap(folder / "packed.xvm").stored_view, nullptr);
}

/// Check fix for: a bare graph, which has no path, ended the program when it was appended.
TEST(Mapper, ABareGraphIsAppendedToAMapWithAPath) {
  map::SemanticMap map = simulatedDrive().map;
  const map::SemanticMap graph = buildMap(map.graph, map.labels, "graph", {});
  const std::size_t poses = map.poses.size(), stretches = map.own_stretches.size();
  appendToMap(map, graph, {});
  EXPECT_EQ(map.sources.back(), "graph");
  EXPECT_EQ(map.poses.size(), poses);
  EXPECT_EQ(map.own_stretches.size(), stretches);
}

TEST(Mapper, AMapThatIsMovedThereAndBackIsTheSamePlace) {
  const map::SemanticMap& map = simulatedDrive().map;
  const Eigen::Isometry3d T =
      Eigen::Translation3d(120.3, -45.6, 3) * Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ());
  const map::SemanticMap moved = inFrameOf(map, map, T);
  const map::SemanticMap back = inFrameOf(map, moved, T.inverse());
  for (std::size_t i = 0; i < map.graph.size(); ++i)
    EXPECT_LT((back.graph.vertices[i].position - map.graph.vertices[i].position).norm(), 1e-9);
  EXPECT_LT((moved.poses[7].translation() - T * map.poses[7].translation()).norm(), 1e-9);
  EXPECT_EQ(moved.bev.sampleCount(), map.bev.sampleCount());
  const auto known = static_cast<double>(map.bev.known.size());
  EXPECT_NEAR(static_cast<double>(moved.bev.known.size()), known, 0.05 * known);
  const auto isIn = [&](const GroundCell& cell) { return map.bev.knownCell(cell.x, cell.y); };
  EXPECT_GT(std::count_if(back.bev.known.begin(), back.bev.known.end(), isIn), 0.9 * known);
  EXPECT_GT(evidenceOfOneFrame(map, back, {}).value().agreement(), 0.8);
}

TEST(Mapper, AMapOfTwoHalvesFindsBoth) {
  const auto& drive = simulatedDrive();
  const auto half = [&](std::size_t first, std::size_t last) {
    // The same frames as a recording of their own.
    struct Part : FrameSource {
      const FrameSource* whole = nullptr;
      std::size_t first = 0, count = 0;
      std::size_t size() const override { return count; }
      Eigen::Isometry3d pose(std::size_t i) const override { return whole->pose(first + i); }
      double stamp(std::size_t i) const override { return whole->stamp(first + i); }
      std::int64_t number(std::size_t i) const override { return whole->number(first + i); }
      Frame read(std::size_t i) const override { return whole->read(first + i); }
      Sensor sensor() const override { return whole->sensor(); }
      const LabelSet& labels() const override { return whole->labels(); }
      const std::string& name() const override { return whole->name(); }
    } part;
    part.whole = drive.sessions.at("forward").get();
    part.first = first;
    part.count = last - first;
    return buildMap({&part}, {});
  };
  const std::size_t size = drive.frames.at("forward").size();
  map::SemanticMap map = half(0, size / 2);
  appendToMap(map, half(size / 2, size), {});
  const Localizer localizer(map, {});
  for (const std::size_t first : {std::size_t{5}, size - 35}) {
    const Localization fix = localizer.localize(drive.query("rear", first, first + 30));
    const Eigen::Vector3d truth = drive.sessions.at("rear")->truth(first + 29).translation();
    EXPECT_LT((fix.T_map_sensor.translation() - truth).norm(), 0.5)
        << "from frame " << first << ": " << fix.reason;
  }
}

/// The same drive three times, each in a place of its own far from the others: long enough for a
/// map that is made part by part.
TEST(Mapper, ALongDriveIsMappedInPartsWhosePointsArePacked) {
  const auto& drive = simulatedDrive();
  const FrameSource& forward = *drive.sessions.at("forward");
  constexpr double kApart_m = 1600;
  std::vector<std::size_t> positions;
  std::vector<Eigen::Isometry3d> poses;
  for (int place = 0; place < 3; ++place) {
    for (std::size_t i = 0; i < forward.size(); ++i) {
      positions.push_back(i);
      poses.push_back(Eigen::Translation3d(place * kApart_m, 0, 0) * forward.pose(i));
    }
  }
  const PosedRecording far(forward, positions, poses);
  Options believed;
  believed.odometry.check = false;  // between its places the drive jumps
  const map::SemanticMap map = buildMap(far, believed);
  const map::SemanticMap& one = drive.map;
  EXPECT_TRUE(isConsistent(map.graph));
  EXPECT_EQ(map.sources.size(), 1u);
  EXPECT_EQ(map.source_of_pose, std::vector<std::uint32_t>(map.poses.size(), 0));
  EXPECT_EQ(map.poses.size(), map.stamps_s.size());
  ASSERT_NE(map.stored_points, nullptr);
  EXPECT_GT(map.stored_points->size(), map.cloud.size());
  EXPECT_TRUE(map.noise);
  const auto is_thrice = [](std::size_t all, std::size_t once) {
    EXPECT_NEAR(static_cast<double>(all), 3.0 * static_cast<double>(once),
                0.05 * static_cast<double>(once));
  };
  is_thrice(map::countsOf(map).points, one.cloud.size());
  is_thrice(map.bev.sampleCount(), one.bev.sampleCount());
  is_thrice(map.graph.size(), one.graph.size());
  // What is found in a copy at the same position relative to it is right.
  const Localization fix = Localizer(map::borrowed(map)).localize(drive.query("rear", 20, 50));
  const Eigen::Vector3d off =
      fix.T_map_sensor.translation() - drive.sessions.at("rear")->truth(49).translation();
  const double copy_m = kApart_m * std::round(off.x() / kApart_m);
  EXPECT_LT((off - Eigen::Vector3d(copy_m, 0, 0)).norm(), 0.5) << fix.reason;
}

TEST(Mapper, RefusesToAppendAFrameThatIsTiltedAgainstThatOfTheMap) {
  map::SemanticMap map = simulatedDrive().map, addition = map;
  addition.bev.alignment = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  EXPECT_THROW(appendToMap(map, addition, {}), Error);
  EXPECT_EQ(map.graph.size(), simulatedDrive().map.graph.size());
  addition.bev.alignment = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX());
  EXPECT_NO_THROW(appendToMap(map, addition, {}));
  EXPECT_EQ(map.source_of_pose.back(), 1u) << "of the second source";
}

}  // namespace
}  // namespace xview
