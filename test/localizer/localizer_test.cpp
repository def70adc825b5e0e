// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "localizer/simulated_drive.h"
#include "search/distance_field.h"
#include "support/test_data.h"
#include "verdict/verdict.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::simulatedDrive;

Options withMethod(const std::string& method) {
  Options options;
  options.method = method;
  return options;
}

double errorOf(const Localization& fix, const std::string& session, std::size_t last_frame) {
  const Eigen::Isometry3d truth = simulatedDrive().sessions.at(session)->truth(last_frame);
  return (fix.T_map_sensor.translation() - truth.translation()).norm();
}

TEST(Localizer, FindsTheRearViewInTheMapOfTheForwardDrive) {
  const auto& drive = simulatedDrive();
  const Localization fix = Localizer(drive.map, {}).localize(drive.query("rear", 10, 40));
  EXPECT_EQ(fix.status, Status::accepted) << fix.reason;
  EXPECT_LT(errorOf(fix, "rear", 39), 0.5);
  EXPECT_GT(fix.inliers, 0);
  EXPECT_FALSE(fix.kept.empty());
  EXPECT_GT(fix.confidence, 0.5);
}

TEST(Localizer, KeepsItsMap) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const Localization expected = Localizer(drive.map).localize(query);
  auto shared = std::make_shared<const map::SemanticMap>(drive.map);
  const std::weak_ptr<const map::SemanticMap> watched = shared;
  {
    const Localizer localizer(std::move(shared));
    EXPECT_FALSE(watched.expired());
    EXPECT_EQ(localizer.localize(query).T_map_sensor.matrix(), expected.T_map_sensor.matrix());
  }
  EXPECT_TRUE(watched.expired());
  Localizer of_a_copy(map::SemanticMap{drive.map});
  const Localizer moved = std::move(of_a_copy);
  EXPECT_EQ(moved.localize(query).T_map_sensor.matrix(), expected.T_map_sensor.matrix());
}

TEST(Localizer, DoesNotCopyAMapThatIsSharedOrMovedIn) {
  const auto& drive = simulatedDrive();
  const auto shared = std::make_shared<const map::SemanticMap>(drive.map);
  const Localizer sharing(shared);
  EXPECT_EQ(&sharing.labels(), &shared->labels);
  map::SemanticMap own = drive.map;
  const auto* classes = &own.labels.classes().begin()->second;
  const Localizer owning(std::move(own));
  EXPECT_EQ(&owning.labels().classes().begin()->second, classes);
}

TEST(Localizer, WithoutAMapIsWrongUse) {
  EXPECT_THROW(Localizer(std::shared_ptr<const map::SemanticMap>()), UsageError);
}

TEST(Localizer, AQueryThatCannotShowTheMapIsHeldAgainstItself) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  Query query = drive.query("rear", 10, 40);
  const DenseEvidence shows = localizer.localize(query).statistics.dense;
  EXPECT_TRUE(shows.map_overlap);
  EXPECT_FALSE(shows.self_consistency);
  ASSERT_TRUE(shows.free_space_violation) << "its depths are exact";
  EXPECT_LT(*shows.free_space_violation, 0.2);
  Query inexact = query;
  for (Point& point : inexact.cloud.points) point.sigma = 0.2f;
  EXPECT_FALSE(localizer.localize(inexact).statistics.dense.free_space_violation);
  query.bev.known.resize(20);  // next to no ground
  const DenseEvidence sparse = localizer.localize(query).statistics.dense;
  EXPECT_FALSE(sparse.map_overlap);
  ASSERT_TRUE(sparse.converged);
  ASSERT_TRUE(sparse.self_consistency);
  EXPECT_GT(*sparse.self_consistency, sparse.inlier_ratio);
  ASSERT_TRUE(sparse.free_space_violation);
  EXPECT_LT(*sparse.free_space_violation, 0.5);
}

TEST(Localizer, InAMapWhoseWrongPlacesFitTheSamePoseIsLessSure) {
  const auto& drive = simulatedDrive();
  map::SemanticMap map = drive.map;
  EXPECT_FALSE(map.wrong_places.empty());
  EXPECT_GE(map.own_stretches.size(), map.wrong_places.size());
  for (const map::OwnStretch& own : map.own_stretches) EXPECT_GT(own.window_m, 0);
  const Query query = drive.query("rear", 10, 40);
  const Localization usual = Localizer(map, {}).localize(query);
  map.wrong_places.assign(60, {0.5, 0.1, {}, {}});
  const Localization alike = Localizer(map, {}).localize(query);
  EXPECT_LT(errorOf(alike, "rear", 39), 0.5);
  EXPECT_GT(alike.statistics.wrong_place_above_null, usual.statistics.wrong_place_above_null + 0.2);
  EXPECT_LT(alike.confidence, usual.confidence);
}

constexpr double kAside_m = 600;  ///< of a copy of the drive

/// Whether a place in the map frame is one of the copy.
bool isOfCopy(double x_m) {
  return x_m > simulatedDrive().map.poses.front().translation().x() + kAside_m / 2;
}

TEST(Localizer, PlacesThatLookAlikeFromAboveAreToldApartByTheirPoints) {
  const auto& drive = simulatedDrive();
  const FrameSource& forward = *drive.sessions.at("forward");
  const PosedRecording copy(forward, Eigen::Isometry3d(Eigen::Translation3d(kAside_m, 0, 0)));
  map::SemanticMap map = buildMap({&forward, &copy}, {});
  // What stands in the copy stands otherwise, and the place itself was seen worse.
  for (Point& p : map.cloud.points) {
    if (!isOfCopy(map.cloud.origin.x() + double{p.x})) continue;
    const bool even = (static_cast<int>(p.x / 3) + static_cast<int>(p.y / 3)) % 2 == 0;
    p.getVector3fMap().head<2>().array() += even ? 1.f : -1.f;
  }
  for (std::vector<BevSample>& samples : map.bev.samples) {
    std::size_t at = 0;
    samples.erase(std::remove_if(samples.begin(), samples.end(),
                                 [&](const BevSample& s) {
                                   return !isOfCopy(map.bev.origin_x + double{s.x}) &&
                                          ++at % 3 == 0;
                                 }),
                  samples.end());
  }
  const Localization fix = Localizer(map, {}).localize(drive.query("rear", 10, 40));
  EXPECT_LT(errorOf(fix, "rear", 39), 0.5) << fix.reason;
  ASSERT_GT(fix.hypotheses.size(), 1U);
  EXPECT_GT(fix.hypotheses[1].score, fix.hypotheses[0].score) << "the copy is better from above";
}

TEST(Localizer, AWellKnownPlaceThatTheQueryDoesNotShowIsNotAllThatIsRegistered) {
  const auto& drive = simulatedDrive();
  constexpr double kBlock_m = 16;
  const FrameSource& forward = *drive.sessions.at("forward");
  const PosedRecording copy(forward, Eigen::Isometry3d(Eigen::Translation3d(kAside_m, 0, 0)));
  map::SemanticMap map = buildMap({&forward, &copy}, {});
  BevGrid& bev = map.bev;
  // Of the place itself every second block is known.
  const auto isUnknown = [&](double x, double y) {
    const auto block = std::floor(x / kBlock_m) + std::floor(y / kBlock_m);
    return !isOfCopy(bev.origin_x + x) && std::fmod(block, 2) != 0;
  };
  for (std::vector<BevSample>& samples : bev.samples) {
    const auto unknown = [&](const BevSample& s) { return isUnknown(s.x, s.y); };
    samples.erase(std::remove_if(samples.begin(), samples.end(), unknown), samples.end());
  }
  const auto unknown = [&](const GroundCell& cell) {
    return isUnknown((cell.x + 0.5) * bev.cell_m, (cell.y + 0.5) * bev.cell_m);
  };
  bev.known.erase(std::remove_if(bev.known.begin(), bev.known.end(), unknown), bev.known.end());
  // On the roads of the copy stand walls.
  for (const BevSample& s : bev[BevChannel::road]) {
    if (!isOfCopy(bev.origin_x + s.x)) continue;
    bev[BevChannel::building].push_back(s);
    bev[BevChannel::obstacle_low].push_back(s);
  }
  const Localization fix = Localizer(map, {}).localize(drive.query("rear", 10, 40));
  EXPECT_LT(errorOf(fix, "rear", 39), 0.5) << fix.reason;
  for (const auto& h : fix.hypotheses)
    std::cerr << h.score << " " << h.T_map_query.translation().transpose() << "\n";
  ASSERT_GT(fix.hypotheses.size(), 1U);
  EXPECT_LT(fix.hypotheses[0].score, verdict::kAboutAsWell * fix.hypotheses[1].score);
}

TEST(Localizer, WalksAloneFindTheRearView) {
  const auto& drive = simulatedDrive();
  const Localization fix =
      Localizer(drive.map, withMethod("walks")).localize(drive.query("rear", 10, 45));
  EXPECT_LT(errorOf(fix, "rear", 44), 2.0) << fix.reason;
  ASSERT_FALSE(fix.hypotheses.empty());
  EXPECT_EQ(fix.hypotheses[0].proposer, Proposer::walks);
}

TEST(Localizer, RefusesAnotherTown) {
  const auto& drive = simulatedDrive();
  for (const char* method : {"auto", "search", "walks"}) {
    const Localizer localizer(drive.map, withMethod(method));
    for (std::size_t first = 0; first + 30 <= drive.frames.at("elsewhere").size(); first += 15) {
      const Localization fix = localizer.localize(drive.query("elsewhere", first, first + 30));
      EXPECT_NE(fix.status, Status::accepted)
          << method << ", frames from " << first << ": " << fix.reason;
    }
  }
}

TEST(Localizer, PoseOfTheSensorDoesNotDependOnTheOriginOfTheOdometry) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  const Localization here = localizer.localize(drive.query("rear", 10, 40));
  for (const Eigen::Vector3d& origin :
       {Eigen::Vector3d(4000.25, -730.5, 12.5), Eigen::Vector3d(431000, 4582000, 1000)}) {
    const auto moved = test::movedFrames(*drive.sessions.at("rear"), poseFromYaw(origin, 2.1));
    const Localization there =
        localizer.localize(makeQuery(moved.data() + 10, moved.data() + 40, drive.labels, {}));
    EXPECT_EQ(there.status, here.status);
    EXPECT_LT((there.T_map_sensor.translation() - here.T_map_sensor.translation()).norm(), 0.1);
    EXPECT_LT(rotationBetween(there.T_map_sensor, here.T_map_sensor), 0.01);
  }
}

TEST(Localizer, FramesOfAFirstCameraAreTurnedUpright) {
  // Odometry relative to an optical frame: y points down, and the camera was pitched.
  const auto& drive = simulatedDrive();
  Eigen::Isometry3d T_optical = Eigen::Isometry3d::Identity();
  T_optical.linear() = (Eigen::AngleAxisd(-M_PI / 2 + 0.1, Eigen::Vector3d::UnitX()) *
                        Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
                           .toRotationMatrix()
                           .transpose();
  T_optical.translation() = Eigen::Vector3d(10, -20, 30);
  const auto rear = test::movedFrames(*drive.sessions.at("rear"), T_optical);
  const Query query = makeQuery(rear.data() + 10, rear.data() + 40, drive.labels, {});
  const Eigen::Isometry3d truth = drive.sessions.at("rear")->truth(39);
  const Localization fix = Localizer(drive.map, {}).localize(query);
  EXPECT_EQ(fix.status, Status::accepted) << fix.reason;
  EXPECT_LT((fix.T_map_sensor.translation() - truth.translation()).norm(), 0.5);
  EXPECT_LT(rotationBetween(fix.T_map_sensor, truth), 0.03);

  const PosedRecording forward(*drive.sessions.at("forward"), T_optical);
  const map::SemanticMap tilted = buildMap({&forward}, {});
  const Localization in_tilted = Localizer(tilted, {}).localize(query);
  EXPECT_EQ(in_tilted.status, Status::accepted) << in_tilted.reason;
  EXPECT_LT((in_tilted.T_map_sensor.translation() - T_optical * truth.translation()).norm(), 0.5);

  const test::TemporaryFolder folder;
  map::saveMap(folder / "tilted.xvm", tilted);
  const Localization in_file = Localizer(map::openMap(folder / "tilted.xvm")).localize(query);
  EXPECT_EQ(in_file.status, Status::accepted) << in_file.reason;
  EXPECT_LT((in_file.T_map_sensor.translation() - T_optical * truth.translation()).norm(), 0.5);
}

TEST(Localizer, AQueryReadFrameByFrameIsThatOfAllItsDigests) {
  const auto& drive = simulatedDrive();
  const FrameSource& rear = *drive.sessions.at("rear");
  const std::vector<PreprocessedFrame>& frames = drive.frames.at("rear");
  const Query all = makeQuery(frames.data(), frames.data() + frames.size(), drive.labels, {});
  std::vector<std::int64_t> seen;
  const Query streamed =
      makeQuery(rear, {}, [&](const PreprocessedFrame& frame) { seen.push_back(frame.number); });
  EXPECT_EQ(seen, all.frames);
  EXPECT_EQ(streamed.frames, all.frames);
  EXPECT_EQ(streamed.sensor, all.sensor);
  EXPECT_EQ(streamed.cloud.typicalSigma(), all.cloud.typicalSigma());
  EXPECT_EQ(streamed.cloud.origin, all.cloud.origin);
  ASSERT_EQ(streamed.cloud.size(), all.cloud.size());
  for (std::size_t i = 0; i < all.cloud.size(); ++i)
    ASSERT_EQ(streamed.cloud.points[i].getVector3fMap(), all.cloud.points[i].getVector3fMap());
  for (std::size_t i = 0; i < all.cloud.size(); ++i) {
    ASSERT_EQ(streamed.cloud.points[i].view, all.cloud.points[i].view);
    ASSERT_GT(all.cloud.points[i].view, 0u) << "the first frames are too far back";
  }
  ASSERT_EQ(streamed.graph.size(), all.graph.size());
  for (std::size_t i = 0; i < all.graph.size(); ++i)
    ASSERT_EQ(streamed.graph.vertices[i].position, all.graph.vertices[i].position);
  EXPECT_EQ(streamed.graph.edges(), all.graph.edges());
  EXPECT_EQ(streamed.bev.sampleCount(), all.bev.sampleCount());
  const Localizer localizer(drive.map, {});
  EXPECT_EQ(localizer.localize(streamed).T_map_query.matrix(),
            localizer.localize(all).T_map_query.matrix());
}

TEST(Localizer, AQueryOfATiltedCameraReadFrameByFrameIsTurnedUprightToo) {
  const auto& drive = simulatedDrive();
  const Eigen::Isometry3d T_tilted(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()));
  const PosedRecording rear(*drive.sessions.at("rear"), T_tilted);
  const Query query = makeQuery(rear, {});
  EXPECT_GT(query.bev.alignment.angularDistance(Eigen::Quaterniond::Identity()), 1);
  const Localization fix = Localizer(drive.map, {}).localize(query);
  EXPECT_EQ(fix.status, Status::accepted) << fix.reason;
}

TEST(Localizer, AnswersAlikeForAnyNumberOfThreads) {
  const auto& drive = simulatedDrive();
  for (const char* method : {"auto", "walks"}) {
    Options one = withMethod(method), two = withMethod(method);
    one.threads = 1;
    two.threads = 2;
    const Localization a = Localizer(drive.map, one).localize(drive.query("rear", 5, 30, one));
    const Localization b = Localizer(drive.map, two).localize(drive.query("rear", 5, 30, two));
    EXPECT_EQ(a.T_map_query.matrix(), b.T_map_query.matrix()) << method;
    EXPECT_EQ(a.confidence, b.confidence) << method;
    EXPECT_EQ(a.covariance, b.covariance) << method;
    EXPECT_EQ(a.reason, b.reason) << method;
    ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size()) << method;
  }
}

/// The drive, and ground far away, with which the map is a large one.
TEST(Localizer, AnswersAlikeWhetherTheViewOfALargeMapIsPackedOrNot) {
  const auto& drive = simulatedDrive();
  map::SemanticMap map = drive.map;
  for (std::int32_t i = 0; i < 500; ++i) map.bev.known.push_back({5000 + 64 * i, 5000, 0, true});
  std::sort(map.bev.known.begin(), map.bev.known.end(), InRowOrder());
  map.null.view = search::fingerprintOf(map.bev);
  const test::TemporaryFolder folder;
  map::saveMap(folder / "map.xvm", map);
  const map::SemanticMap whole = map::unpacked(map::openMap(folder / "map.xvm")),
                         packed = map::openMap(folder / "map.xvm");
  ASSERT_NE(packed.stored_view, nullptr);
  const Localizer in_whole(map::borrowed(whole)), in_packed(map::borrowed(packed));
  for (const char* session : {"rear", "elsewhere"}) {
    Query query = drive.query(session, 5, 24);
    for (const bool with_points : {true, false}) {
      if (!with_points) query.cloud = {};
      const Localization a = in_whole.localize(query), b = in_packed.localize(query);
      EXPECT_EQ(a.status, b.status) << session;
      EXPECT_EQ(a.confidence, b.confidence);
      EXPECT_EQ(a.T_map_query.matrix(), b.T_map_query.matrix());
      EXPECT_EQ(a.covariance, b.covariance);
      EXPECT_EQ(a.reason, b.reason);
      EXPECT_EQ(a.hypotheses.size(), b.hypotheses.size());
      const Explanation said = in_whole.explain(query, a), also = in_packed.explain(query, b);
      ASSERT_EQ(said.contributions.size(), also.contributions.size());
      for (std::size_t i = 0; i < said.contributions.size(); ++i)
        EXPECT_EQ(said.contributions[i].residual_m, also.contributions[i].residual_m);
    }
  }
}

TEST(Localizer, AnswersAlikeWhetherTheVerticesOfABareGraphArePackedOrNot) {
  const auto& drive = simulatedDrive();
  map::SemanticMap map;
  map.labels = drive.map.labels;
  map.graph = drive.map.graph;
  const test::TemporaryFolder folder;
  map::saveMap(folder / "map.xvm", map);
  const map::SemanticMap whole = map::unpacked(map::openMap(folder / "map.xvm")),
                         packed = map::openMap(folder / "map.xvm");
  ASSERT_EQ(whole.stored_vertices, nullptr);
  ASSERT_NE(packed.stored_vertices, nullptr);
  Query query = drive.query("rear", 5, 24);
  query.cloud = {};
  query.bev = {};
  for (const char* method : {"auto", "walks"}) {
    const Localizer in_whole(map::borrowed(whole), withMethod(method)),
        in_packed(map::borrowed(packed), withMethod(method));
    const Localization a = in_whole.localize(query), b = in_packed.localize(query);
    EXPECT_FALSE(b.hypotheses.empty()) << method;
    EXPECT_EQ(a.status, b.status) << method;
    EXPECT_EQ(a.confidence, b.confidence) << method;
    EXPECT_EQ(a.T_map_query.matrix(), b.T_map_query.matrix()) << method;
    EXPECT_EQ(a.covariance, b.covariance) << method;
    EXPECT_EQ(a.reason, b.reason) << method;
    EXPECT_EQ(in_whole.explain(query, a).contributions.size(),
              in_packed.explain(query, b).contributions.size());
  }
}

TEST(Localizer, ErrorsStayWithinThreeSigma) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  int accepted = 0;
  for (std::size_t first = 0; first + 25 <= drive.frames.at("rear").size(); first += 10) {
    const Localization fix = localizer.localize(drive.query("rear", first, first + 25));
    if (!fix.accepted()) continue;
    ++accepted;
    const Eigen::Vector3d error =
        fix.T_map_sensor.translation() - drive.sessions.at("rear")->truth(first + 24).translation();
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_LT(std::abs(error(axis)), 3 * std::sqrt(fix.covariance(axis, axis)))
          << "from frame " << first;
  }
  EXPECT_GE(accepted, 5);
}

/// Check fix for: the bird's-eye view of a whole window, as rigid, took back the pose that the
/// points of its end had found.
TEST(Localizer, TheEndOfAWindowThatDriftsIsWhereItsPointsAre) {
  const auto& drive = simulatedDrive();
  constexpr double kLonger = 0.05;  ///< share of the way by which the odometry is wrong
  std::vector<PreprocessedFrame> frames = drive.frames.at("rear");
  frames.resize(60);
  const Eigen::Vector3d last = frames.back().T_odom_sensor.translation();
  for (PreprocessedFrame& frame : frames) {
    const Eigen::Vector3d too_far = kLonger * (frame.T_odom_sensor.translation() - last);
    frame.T_odom_sensor.pretranslate(too_far);
    frame.cloud.origin += too_far;
  }
  const Localization fix =
      Localizer(drive.map, {})
          .localize(makeQuery(frames.data(), frames.data() + frames.size(), drive.labels, {}));
  EXPECT_TRUE(fix.statistics.dense.converged) << fix.reason;
  EXPECT_LT(errorOf(fix, "rear", 59), 0.2);
}

TEST(Localizer, WithoutPointsThePoseIsOpenAlongTheWay) {
  const auto& drive = simulatedDrive();
  Query query = drive.query("rear", 10, 40);
  query.cloud = {};
  const Localization fix = Localizer(drive.map, {}).localize(query);
  ASSERT_EQ(fix.status, Status::accepted) << fix.reason;
  EXPECT_LT(errorOf(fix, "rear", 39), 0.75);
  Eigen::Vector3d way = fix.T_map_query.linear() *
                        (query.poses.back().translation() - (query.poses.end() - 4)->translation());
  way.z() = 0;
  way.normalize();
  const Eigen::Vector3d side(-way.y(), way.x(), 0);
  const Eigen::Matrix3d position = fix.covariance.topLeftCorner<3, 3>();
  EXPECT_NEAR(std::sqrt(way.dot(position * way)), 0.25, 0.02);
  EXPECT_NEAR(std::sqrt(side.dot(position * side)), 0.11, 0.03);
}

TEST(Localizer, APriorElsewhereLeavesNoAcceptedPose) {
  const auto& drive = simulatedDrive();
  const Eigen::Vector3d truth = drive.sessions.at("rear")->truth(39).translation();
  Options near, far;
  near.prior.near = std::to_string(truth.x()) + "," + std::to_string(truth.y()) + ",15";
  far.prior.near = std::to_string(truth.x() + 70) + "," + std::to_string(truth.y() + 70) + ",15";
  EXPECT_EQ(Localizer(drive.map, near).localize(drive.query("rear", 10, 40)).status,
            Status::accepted);
  EXPECT_NE(Localizer(drive.map, far).localize(drive.query("rear", 10, 40)).status,
            Status::accepted);
}

TEST(Localizer, NoAcceptedPoseIsOutsideOfItsPrior) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const Eigen::Vector3d truth = drive.sessions.at("rear")->truth(39).translation();
  int inside = 0;
  for (int i = 0; i < 12; ++i) {
    const double direction = 0.5 * i,
                 off = i % 2 == 0
                           ? 4.0
                           : 7.0;  // of circles of 6 m: the truth is inside, then a little outside
    Options options;
    options.prior.near = std::to_string(truth.x() + off * std::cos(direction)) + "," +
                         std::to_string(truth.y() + off * std::sin(direction)) + ",6";
    const Localization fix = Localizer(drive.map, options).localize(query);
    if (i % 2 == 1) {
      EXPECT_FALSE(fix.accepted()) << "the truth is 1 m outside, but: " << fix.reason;
    }
    if (fix.accepted()) {
      EXPECT_LT(errorOf(fix, "rear", 39), 0.5);
    }
    inside += fix.accepted();
  }
  EXPECT_EQ(inside, 6);
}

TEST(Localizer, ExpectedPoseIsFoundThereOrNotAtAll) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const Localizer localizer(drive.map, {});
  const Eigen::Isometry3d truth =
      drive.sessions.at("rear")->truth(39) * query.poses.back().inverse();
  const auto moved = [&](double x) {
    return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)) * truth;
  };
  const Localization found = localizer.localize(query, ExpectedPose{moved(2), 4, 0.2});
  EXPECT_TRUE(found.accepted()) << found.reason;
  EXPECT_LT(errorOf(found, "rear", 39), 0.5);
  EXPECT_FALSE(localizer.localize(query, ExpectedPose{moved(30), 4, 0.2}).accepted());
}

TEST(Localizer, CheckClimbsOnlyAsFarAsItMay) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const Localizer localizer(drive.map, {});
  const Localization fix = localizer.localize(query);
  const Eigen::Isometry3d beside =
      Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0)) * fix.T_map_query;
  const std::vector<PoseCheck> found = localizer.check(query, {beside, fix.T_map_query}, 2);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_LT(
      (found[0].T_map_query * query.poses.back().translation() - fix.T_map_sensor.translation())
          .norm(),
      0.6);
  EXPECT_GT(found[0].evidence.score, 0.9 * fix.hypotheses[0].score);
  const PoseCheck held = localizer.check(query, {beside}, 0.01)[0];
  EXPECT_TRUE(held.T_map_query.isApprox(beside));
  EXPECT_LT(held.evidence.score, found[0].evidence.score);
}

TEST(Localizer, JudgesPosesOfOthersAsItsOwn) {
  const auto& drive = simulatedDrive();
  const Query query = drive.query("rear", 10, 40);
  const Localizer localizer(drive.map, {});
  const Localization fix = localizer.localize(query);
  ASSERT_TRUE(fix.accepted()) << fix.reason;
  const auto beside = [&](double x) {
    return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)) * fix.T_map_query;
  };
  const Eigen::Isometry3d about =
      fix.T_map_query * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
  const std::vector<Localization> judged =
      localizer.judge(query, {fix.T_map_query, beside(0.5), beside(5), beside(30), about});
  ASSERT_EQ(judged.size(), 5u);
  EXPECT_EQ(judged[0].confidence, fix.confidence);
  EXPECT_TRUE(judged[0].T_map_query.isApprox(fix.T_map_query, 0));
  EXPECT_TRUE(judged[1].accepted()) << judged[1].reason;
  EXPECT_LT(errorOf(judged[1], "rear", 39), 0.5);
  for (std::size_t i = 2; i < judged.size(); ++i) {
    EXPECT_FALSE(judged[i].accepted()) << i << ": " << judged[i].reason;
    EXPECT_FALSE(judged[i].hypotheses.empty()) << i;
  }
}

/// What nobody would find is not believed because somebody says so.
TEST(Localizer, BelievesNoPoseOfAStranger) {
  const auto& drive = simulatedDrive();
  const Query stranger = drive.query("elsewhere", 0, 30);
  for (const Localization& fix : Localizer(drive.map, {})
                                     .judge(stranger, {drive.sessions.at("rear")->truth(20),
                                                       drive.sessions.at("rear")->truth(50)}))
    EXPECT_FALSE(fix.accepted()) << fix.reason;
}

TEST(Localizer, APriorThatIsNoCircleIsWrongUse) {
  Options options;
  for (const char* text : {"1,2", "a,b,c", "1,2,0", "1,2,3,4"}) {
    options.prior.near = text;
    EXPECT_THROW(Localizer(simulatedDrive().map, options), UsageError) << text;
  }
}

TEST(Localizer, AnEmptyQueryIsRejected) {
  const auto& drive = simulatedDrive();
  Query empty;
  empty.labels = drive.labels;
  empty.poses.push_back(Eigen::Isometry3d::Identity());
  for (const char* method : {"auto", "search", "walks"}) {
    const Localization fix = Localizer(drive.map, withMethod(method)).localize(empty);
    EXPECT_EQ(fix.status, Status::rejected) << method;
    EXPECT_TRUE(fix.hypotheses.empty()) << method;
    EXPECT_FALSE(fix.reason.empty()) << method;
  }
}

TEST(Localizer, AQueryOfNoFramesIsRejected) {
  const auto& drive = simulatedDrive();
  const PreprocessedFrame* none = drive.frames.at("rear").data();
  const Query query = makeQuery(none, none, drive.labels, {});
  for (const char* method : {"auto", "search", "walks"}) {
    const Localization fix = Localizer(drive.map, withMethod(method)).localize(query);
    EXPECT_EQ(fix.status, Status::rejected) << method;
    EXPECT_TRUE(fix.hypotheses.empty()) << method;
  }
}

TEST(Localizer, AnEmptyMapRejectsEverything) {
  const auto& drive = simulatedDrive();
  map::SemanticMap empty;
  empty.labels = drive.labels;
  for (const char* method : {"auto", "walks"}) {
    EXPECT_EQ(Localizer(empty, withMethod(method)).localize(drive.query("rear", 0, 20)).status,
              Status::rejected)
        << method;
  }
}

}  // namespace
}  // namespace xview
