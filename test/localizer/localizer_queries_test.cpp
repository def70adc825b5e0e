// SPDX-License-Identifier: BSD-3-Clause
// Clouds and recordings as a program of its own has them: a localizer makes queries of them.
#include <gtest/gtest.h>
#include <pcl/point_types.h>

#include <cmath>
#include <functional>
#include <utility>

#include "base/pose.h"
#include "compare/changes.h"
#include "localizer/simulated_drive.h"
#include "localizer/tracker.h"
#include "place/raw_recording.h"
#include "search/likelihoods.h"
#include "support/test_data.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/cloud_recording.h"
#include "xview/follower.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/sequence.h"

namespace xview {
namespace {

using test::simulatedDrive;

/// What the frames of a session saw, in one cloud.
template <class PointT>
pcl::PointCloud<PointT> cloudOf(const std::string& session, std::size_t first, std::size_t last) {
  const std::vector<PreprocessedFrame>& frames = simulatedDrive().frames.at(session);
  pcl::PointCloud<PointT> cloud;
  for (std::size_t i = first; i < last; ++i) {
    for (std::size_t k = 0; k < frames[i].cloud.size(); ++k) {
      PointT point;
      point.getVector3fMap() = frames[i].cloud.position(k).template cast<float>();
      if constexpr (HasLabel<PointT>::value) point.label = frames[i].cloud.points[k].label;
      cloud.push_back(point);
    }
  }
  return cloud;
}

/// Of the last sensor of a window of the drive back.
double errorAt(const Eigen::Isometry3d& T_map_query, std::size_t frame) {
  const auto& rear = *simulatedDrive().sessions.at("rear");
  return (T_map_query * rear.pose(frame).translation() - rear.truth(frame).translation()).norm();
}

TEST(LocalizerQueries, ALabelledCloudOfPclIsFoundInALabelledMap) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const Localization fix =
      localizer.localize(cloudOf<pcl::PointXYZL>("rear", 10, 40), localizer.labels());
  EXPECT_TRUE(fix.accepted()) << fix.reason;
  EXPECT_LT(errorAt(fix.T_map_query, 39), 0.5);
}

/// The drive back in one cloud of its own frame, with stray points and zeros; moved, as a file.
std::string movedCloud(const Eigen::Isometry3d& T, const std::vector<float>& strays,
                       std::size_t zeros, const std::string& ending) {
  LabelledCloud cloud;
  cloud.origin = T.translation();
  for (const Point& p : cloudOf<Point>("rear", 10, 40)) {
    cloud.points.push_back(p);
    cloud.points.back().getVector3fMap() = T.linear().cast<float>() * p.getVector3fMap();
  }
  const std::uint32_t label = cloud.points[0].label;
  for (const float away : strays) {
    cloud.points.push_back(Point(away, -away, 0.1F * away, label));
    std::swap(cloud.points.front(), cloud.points.back());
  }
  const Eigen::Vector3f zero = -T.translation().cast<float>();
  for (std::size_t i = 0; i < zeros; ++i)
    cloud.points.push_back(Point(zero.x(), zero.y(), zero.z(), label));
  const std::string path = testing::TempDir() + "/moved" + ending;
  const auto write = ending == ".ply" ? io::writePly : io::writePcd;
  write(path, cloud, &simulatedDrive().labels);
  return path;
}

TEST(LocalizerQueries, ACloudIsFoundWhereverItsZeroIsAndWhateverStraysItHas) {
  const Localizer localizer(simulatedDrive().map);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity(),
                          utm = poseFromYaw({431000, 4582000, 120}, 0),
                          turned = poseFromYaw({431000, 4582000, 120}, M_PI);
  const struct {
    Eigen::Isometry3d T;
    std::vector<float> strays;
    std::size_t zeros;
    const char* ending;
  } cases[] = {{poseFromYaw({0, 0, 200}, 0), {}, 0, ".pcd"},
               {poseFromYaw({100, 0, 0}, 0), {}, 0, ".pcd"},
               {poseFromYaw({-200, 0, 60}, 0), {}, 0, ".pcd"},
               {poseFromYaw({0, 0, 1000}, M_PI), {}, 0, ".ply"},
               {here, {1e10F, 1e30F}, 0, ".pcd"},
               {utm, {}, 1, ".ply"},
               {turned, {1e6F, 1e6F, 5e3F, 1e9F, 3e30F}, 3000, ".pcd"}};
  const Localization expected =
      localizer.localize(*io::openRecording(movedCloud(here, {}, 0, ".pcd"), {}));
  ASSERT_TRUE(expected.accepted());
  const Eigen::Vector3d sensor = simulatedDrive().sessions.at("rear")->pose(39).translation();
  std::size_t poses = 0;
  for (const auto& c : cases) {
    const auto recording = io::openRecording(movedCloud(c.T, c.strays, c.zeros, c.ending), {});
    const Localization fix = localizer.localize(*recording);
    EXPECT_TRUE(fix.accepted()) << fix.reason;
    const Eigen::Isometry3d T_map_query = fix.T_map_query * c.T;
    EXPECT_LT((T_map_query * sensor - expected.T_map_query * sensor).norm(), 0.05);
    EXPECT_LT(rotationBetween(T_map_query, expected.T_map_query), 0.002);
    EXPECT_EQ(recording->leftOut().any(), !c.strays.empty() || c.zeros > 0);
    for (const Eigen::Isometry3d& T_map_sensor : fix.trajectory)
      EXPECT_LT((T_map_sensor.translation() - fix.T_map_sensor.translation()).norm(), 1e-6);
    poses += fix.trajectory.size();
  }
  EXPECT_GT(poses, 0u) << "no pose was that of the posterior";
}

TEST(LocalizerQueries, ARawCloudOfPclIsFoundInARawOne) {
  const std::size_t last = simulatedDrive().frames.at("forward").size();
  const Localizer localizer(buildMap(cloudOf<pcl::PointXYZ>("forward", 0, last)));
  EXPECT_TRUE(knowsShapesOnly(localizer.labels()));
  const Localization fix = localizer.localize(cloudOf<pcl::PointXYZ>("rear", 10, 40));
  EXPECT_TRUE(fix.accepted()) << fix.reason;
  EXPECT_LT(errorAt(fix.T_map_query, 39), 0.5);
}

TEST(LocalizerQueries, LabelsThatNobodyExplainsAreLeftAside) {
  const Localizer localizer(simulatedDrive().map);
  const Localization labelled = localizer.localize(cloudOf<pcl::PointXYZL>("rear", 10, 40)),
                     raw = localizer.localize(cloudOf<pcl::PointXYZ>("rear", 10, 40));
  EXPECT_EQ(labelled.reason, raw.reason);
  EXPECT_EQ(labelled.T_map_query.matrix(), raw.T_map_query.matrix());
}

/// A drive without its labels.
class RawDrive final : public ForwardingSource {
 public:
  explicit RawDrive(const FrameSource& drive) : ForwardingSource(drive) {}
  const LabelSet& labels() const override { return none_; }
  Frame read(std::size_t index) const override {
    Frame frame = ForwardingSource::read(index);
    frame.label = LabelImage();
    return frame;
  }

 private:
  LabelSet none_;
};

TEST(LocalizerQueries, ARawRecordingMakesAMapAndAQueryOfShapes) {
  const auto& drive = simulatedDrive();
  const RawDrive forward(*drive.sessions.at("forward"));
  const Localizer localizer(buildMap(forward));
  EXPECT_TRUE(knowsShapesOnly(localizer.labels()));
  const Query query = localizer.query(RawDrive(*drive.sessions.at("rear")));
  EXPECT_TRUE(knowsShapesOnly(query.labels));
  EXPECT_GT(query.graph.size(), 20u);
  EXPECT_TRUE(localizer.localize(query).accepted());
  // In a map of shapes labels are left aside.
  EXPECT_TRUE(knowsShapesOnly(localizer.query(*drive.sessions.at("rear")).labels));
}

/// From the ground by the table of labels, from the air by that of shapes; see
/// search::kShapesInLabels.
TEST(LocalizerQueries, OfShapesHaveLikelihoodsOfTheirOwnInALabelledMap) {
  const auto& drive = simulatedDrive();
  Query query = Localizer(drive.map).query(RawDrive(*drive.sessions.at("rear")));
  ASSERT_TRUE(knowsShapesOnly(query.labels));
  const auto scoreWith = [&](const std::string& table) {
    Options options;
    options.places.likelihoods = table;
    const Localization fix = Localizer(drive.map, options).localize(query);
    return fix.hypotheses.empty() ? 0 : fix.hypotheses[0].score;
  };
  const test::TemporaryFolder folder;
  const std::string of_labels = folder / "labels.txt";
  test::writeText(of_labels, toText(search::defaultLikelihoods()));
  EXPECT_GT(scoreWith(""), 0);
  EXPECT_EQ(scoreWith(""), scoreWith(of_labels));
  EXPECT_NE(scoreWith(""), scoreWith(search::kShapes));
  query.bev.aerial = true;
  EXPECT_GT(scoreWith(""), 0);
  EXPECT_EQ(scoreWith(""), scoreWith(search::kShapes));
  EXPECT_NE(scoreWith(""), scoreWith(of_labels));
}

TEST(LocalizerQueries, ADigestWithoutClassesIsAnError) {
  const RawDrive rear(*simulatedDrive().sessions.at("rear"));
  for (const std::string& said :
       {test::messageOf<Error>([&] { preprocessRecording(rear, {}); }),
        test::messageOf<Error>([&] { preprocessFrame(rear.read(0), LabelSet(), {}); })})
    EXPECT_NE(said.find("no labels"), std::string::npos) << said;
}

TEST(LocalizerQueries, FramesOneByOneGiveTheAnswerOfTheirRecording) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const PosedRecording window(*drive.sessions.at("rear"), 10, [&] {
    std::vector<Eigen::Isometry3d> poses;
    for (std::size_t i = 10; i < 40; ++i) poses.push_back(drive.sessions.at("rear")->pose(i));
    return poses;
  }());
  std::vector<PreprocessedFrame> frames;
  for (std::size_t i = 0; i < window.size(); ++i)
    frames.push_back(localizer.preprocess(window.read(i), window.labels()));
  const Localization one_by_one = localizer.localize(localizer.query(frames, window.labels()));
  const Localization whole = localizer.localize(window);
  EXPECT_TRUE(whole.accepted()) << whole.reason;
  EXPECT_LT((one_by_one.T_map_sensor.translation() - whole.T_map_sensor.translation()).norm(), 0.1);
  EXPECT_EQ(localizer.localize(drive.query("rear", 10, 40)).T_map_sensor.matrix(),
            one_by_one.T_map_sensor.matrix());
}

/// Clouds in a model of the town, whose lengths nobody told.
TEST(LocalizerQueries, HaveTheLengthsOfTheMap) {
  Options of_rooms;
  of_rooms.size = "room";
  auto town = cloudOf<pcl::PointXYZL>("forward", 0, simulatedDrive().frames.at("forward").size());
  auto window = cloudOf<pcl::PointXYZL>("rear", 10, 40);
  for (auto* cloud : {&town, &window}) {
    for (pcl::PointXYZL& p : *cloud) p.getVector3fMap() *= static_cast<float>(kRoomScale);
  }
  const LabelSet& labels = simulatedDrive().labels;
  const Localizer localizer(buildMap(town, labels, of_rooms));
  EXPECT_EQ(localizer.size(), kRoomScale);
  EXPECT_EQ(localizer.options().size, "room");
  const Localization fix = localizer.localize(window, labels);
  ASSERT_FALSE(fix.hypotheses.empty()) << fix.reason;
  Eigen::Isometry3d T = fix.T_map_query;
  scaleLengths(1 / kRoomScale, T);
  EXPECT_LT(errorAt(T, 39), 1);
}

TEST(CloudRecordings, TakeFinitePointsWithTheirLabels) {
  pcl::PointCloud<pcl::PointXYZL> cloud;
  for (const float x : {1.F, NAN, 3.F}) {
    pcl::PointXYZL point;
    point.x = x;
    point.label = 7;
    cloud.push_back(point);
  }
  LabelSet labels("own");
  labels.add({7, "pole", {}, Role::object, Kind::pole});
  CloudRecording scans(labels, "driver");
  Eigen::Isometry3d pose(Eigen::Translation3d(0, 5, 0));
  scans.add(cloud, Eigen::Isometry3d::Identity(), 1.5);
  scans.add(cloud, pose, 2.5);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans.sensor(), Sensor::lidar);
  EXPECT_EQ(scans.stamp(1), 2.5);
  EXPECT_EQ(scans.number(1), 1);
  EXPECT_EQ(scans.pose(1).matrix(), pose.matrix());
  const Frame frame = scans.read(1);
  ASSERT_EQ(frame.cloud.size(), 2u);
  EXPECT_EQ(frame.cloud.points[1].x, 3);
  EXPECT_EQ(frame.cloud.points[1].label, 7u);
}

TEST(CloudRecordings, RefuseWhatTheyCannotMean) {
  const pcl::PointCloud<pcl::PointXYZ> bare;
  const pcl::PointCloud<pcl::PointXYZL> labelled;
  CloudRecording scans(simulatedDrive().labels);
  EXPECT_THROW(scans.add(bare), UsageError) << "classes without a field of labels";
  scans.add(labelled, Eigen::Isometry3d::Identity());
  EXPECT_THROW(scans.add(labelled), UsageError) << "one has a pose, the other has none";
  Eigen::Isometry3d stretched = Eigen::Isometry3d::Identity();
  stretched.linear() *= 2;
  EXPECT_THROW(scans.add(labelled, stretched), UsageError);
  EXPECT_EQ(scans.size(), 1u);
  EXPECT_THROW(buildMap(std::vector<const FrameSource*>{}, Options()), UsageError);
  const Localizer localizer(simulatedDrive().map);
  EXPECT_EQ(localizer.localize(bare).status, Status::rejected);
}

/// The same for every call that asks for one pose: nothing that is no pose of this world.
TEST(LocalizerQueries, PosesThatAreNoneAreRefused) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const Query query = drive.query("rear", 10, 14);
  const auto at = [](double x) {
    return Eigen::Isometry3d(Eigen::Translation3d(Eigen::Vector3d::Constant(x)));
  };
  Eigen::Isometry3d stretched = at(0), empty;
  stretched.linear() *= 2;
  empty.matrix().setConstant(NAN);
  for (const Eigen::Isometry3d& T : {at(2e9), at(1e300), at(INFINITY), at(NAN), stretched, empty}) {
    EXPECT_THROW(localizer.check(query, {T}, 1), UsageError);
    EXPECT_THROW(localizer.judge(query, {T}), UsageError);
    EXPECT_THROW(localizer.describe(query, {T, {}}), UsageError);
    EXPECT_THROW(localizer.priorAllows(query, T), UsageError);
    EXPECT_THROW(localizer.localize(query, {T, 5, 0.1}), UsageError);
    EXPECT_THROW(inFrameOf(drive.map, drive.map, T), UsageError);
  }
  for (const double wrong : {double(NAN), double(INFINITY), -1.0}) {
    EXPECT_THROW(localizer.localize(query, {at(0), wrong, 0.1}), UsageError);
    EXPECT_THROW(localizer.localize(query, {at(0), 5, wrong}), UsageError);
  }
  EXPECT_THROW(localizer.check(query, {at(0)}, NAN), UsageError);
  EXPECT_EQ(localizer.check(query, {at(9e7)}, 1).size(), 1u) << "far off, but on this world";
  EXPECT_EQ(localizer.check(query, {}, 1).size(), 0u);
}

TEST(LocalizerQueries, QueriesThatAreNoneAreRefused) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const Query query = drive.query("rear", 10, 14);
  const auto expectRefused = [&](const char* what, const std::function<void(Query&)>& spoil) {
    Query spoilt = query;
    spoil(spoilt);
    EXPECT_THROW(localizer.localize(spoilt), UsageError) << what;
    EXPECT_THROW(localizer.check(spoilt, {Eigen::Isometry3d::Identity()}, 1), UsageError) << what;
    EXPECT_THROW(Tracker(localizer, {}).follow(spoilt), UsageError) << what;
    EXPECT_THROW(Sequence(localizer).add(spoilt, 0, 4), UsageError) << what;
  };
  expectRefused("empty", [](Query& q) { q = Query(); });
  expectRefused("no pose", [](Query& q) { q.poses.clear(); });
  expectRefused("NaN in a pose", [](Query& q) { q.poses[1].translation().x() = NAN; });
  expectRefused("far pose", [](Query& q) { q.poses[1].translation().x() = 1e300; });
  expectRefused("NaN in a vertex", [](Query& q) { q.graph.vertices[0].position.x() = NAN; });
  expectRefused("edges to nowhere",
                [](Query& q) { q.graph.neighbours.assign(q.graph.size(), {1000000}); });
  expectRefused("no edges", [](Query& q) {
    q.graph.neighbours.clear();
    q.graph.edge_radius_m = 0;
  });
  expectRefused("NaN in a point", [](Query& q) { q.cloud.points[0].x = NAN; });
  expectRefused("view of no pose", [](Query& q) { q.cloud.points[0].view = 1000; });
  expectRefused("cells of no size", [](Query& q) { q.bev.cell_m = 0; });
  Localization other = localizer.localize(query);
  other.hypotheses.resize(1);
  other.kept = {{1000000, 0, 1}};
  EXPECT_THROW(localizer.explain(query, other), UsageError);
}

TEST(LocalizerQueries, UnderABudgetWholeCloudsAndRecordingsAreAnsweredToo) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map);
  const auto cloud = cloudOf<pcl::PointXYZ>("rear", 10, 14);
  const BudgetLimits limits{1e-9, 0};
  constexpr const char* kSaid = "the time of 1e-09 s ended in";
  {
    const Budget budget(limits);
    for (const Localization& fix :
         {localizer.localize(cloud), localizer.localize(*drive.sessions.at("rear"))}) {
      EXPECT_EQ(fix.status, Status::rejected);
      EXPECT_NE(fix.reason.find(kSaid), std::string::npos) << fix.reason;
    }
  }
  Follower follower(localizer);
  const FollowAnswer followed = follower.withinBudget(
      limits, [&] { return follower.add(cloud, Eigen::Isometry3d::Identity()); });
  EXPECT_FALSE(followed.found());
  EXPECT_NE(followed.reason.find(kSaid), std::string::npos) << followed.reason;
}

TEST(LocalizerQueries, ALocalizerThatWasMovedFromSaysSo) {
  Localizer localizer(simulatedDrive().map);
  const Query query = simulatedDrive().query("rear", 10, 14);
  const Localizer taken = std::move(localizer);
  const auto expectSaid = [&](const std::function<void()>& call) {
    try {
      call();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find("moved from"), std::string::npos) << e.what();
    }
  };
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  expectSaid([&] { localizer.localize(query); });
  expectSaid([&] { localizer.localize(query, {here, 1, 1}); });
  expectSaid([&] { localizer.localize(pcl::PointCloud<pcl::PointXYZ>()); });
  expectSaid([&] { localizer.check(query, {here}, 1); });
  expectSaid([&] { localizer.describe(query, {here, {}}); });
  expectSaid([&] { localizer.priorAllows(query, here); });
  expectSaid([&] { localizer.judge({}); });
  expectSaid([&] { localizer.labels(); });
  localizer = Localizer(simulatedDrive().map);
  EXPECT_NO_THROW(localizer.labels());
}

TEST(LocalizerQueries, WhatIsMissingIsSaid) {
  const auto& drive = simulatedDrive();
  EXPECT_THROW(buildMap(std::vector<const FrameSource*>{nullptr}, Options()), UsageError);
  EXPECT_THROW(CloudRecording().read(0), UsageError);
  SemanticGraph graph;
  graph.vertices.resize(2);
  graph.neighbours = {{7}, {}};
  EXPECT_THROW(makeQuery(graph, drive.labels, {}), UsageError);
  EXPECT_THROW(buildMap(graph, drive.labels, "graph", {}), UsageError);
  PlaceBuilder builder(drive.labels, {}, PlaceUse::query);
  EXPECT_THROW(builder.add(PlaceBuilder::SharedFrame()), UsageError);
  PreprocessedFrame cut = drive.frames.at("rear")[0];
  cut.weights.clear();
  EXPECT_THROW(builder.add(std::move(cut)), UsageError);
  Frame frame = drive.sessions.at("rear")->read(0);
  frame.label = LabelImage(3, 3);
  EXPECT_THROW(preprocessFrame(frame, drive.labels, {}), Error) << "images of two sizes";
  frame.T_odom_sensor.translation().x() = 1e300;
  EXPECT_THROW(preprocessFrame(frame, drive.labels, {}), UsageError) << "a far pose";
  Place place = drive.map;
  EXPECT_THROW(removeObjects(place, {place.graph.size()}), UsageError);
}

TEST(Follower, SaysWhatEachWindowSays) {
  const auto& drive = simulatedDrive();
  const auto& rear = *drive.sessions.at("rear");
  const Localizer localizer(drive.map);
  Follower follower(localizer, {15, 15});
  int windows = 0, expected = 0;
  for (std::size_t i = 0; i < 45; ++i) {
    const FollowAnswer answer = follower.add(rear.read(i), rear.labels());
    EXPECT_EQ(answer.window.has_value(), i % 15 == 14) << i;
    if (!answer.window) continue;
    ++windows;
    expected += answer.was_expected;
    EXPECT_EQ(answer.expected_within_m > 0, windows > 1);
    const Localization alone = localizer.localize(drive.query("rear", i - 14, i + 1));
    EXPECT_EQ(answer.window->accepted(), alone.accepted());
    EXPECT_LT((answer.window->T_map_sensor.translation() - alone.T_map_sensor.translation()).norm(),
              0.1);
    EXPECT_TRUE(answer.found()) << answer.reason;
    EXPECT_LT((answer.T_map_sensor.translation() - rear.truth(i).translation()).norm(), 1);
  }
  EXPECT_EQ(windows, 3);
  EXPECT_EQ(expected, 2);
}

}  // namespace
}  // namespace xview
