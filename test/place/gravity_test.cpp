// SPDX-License-Identifier: BSD-3-Clause
// Queries and maps whose z axis does not point up.
#include "place/gravity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/pose.h"
#include "base/random.h"
#include "localizer/simulated_drive.h"
#include "place/edges.h"
#include "xview/localizer.h"

namespace xview {
namespace {

using test::simulatedDrive;

constexpr double kDegree = M_PI / 180;
constexpr std::size_t kFirst = 10, kLast = 40;  // frames of the rear session

Options withGravity(const std::string& gravity) {
  Options options;
  options.gravity = gravity;
  return options;
}

Eigen::Isometry3d turnBy(double degrees, std::uint64_t seed) {
  Random random(seed);
  const double x = random.normal(), y = random.normal(), z = random.normal();
  Eigen::Isometry3d T(Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d(x, y, z).normalized()));
  T.translation() = Eigen::Vector3d(20, -300, 7);
  return T;
}

double tiltOf(const Eigen::Quaterniond& upright, const Eigen::Isometry3d& T_new_old) {
  const Eigen::Vector3d up = upright * (T_new_old.linear() * Eigen::Vector3d::UnitZ());
  return std::acos(std::min(1.0, up.z())) / kDegree;
}

struct Turned {
  Query query;
  Eigen::Isometry3d truth;  ///< T_map_query
};

Turned turnedFrames(const Eigen::Isometry3d& T, const Options& options) {
  const auto& drive = simulatedDrive();
  const auto frames = test::movedFrames(*drive.sessions.at("rear"), T);
  Turned turned{makeQuery(frames.data() + kFirst, frames.data() + kLast, drive.labels, options),
                {}};
  turned.truth =
      drive.sessions.at("rear")->truth(kLast - 1) * frames[kLast - 1].T_odom_sensor.inverse();
  return turned;
}

/// The points of the window as one cloud, without any view-point.
Turned turnedCloud(const Eigen::Isometry3d& T, const Options& options) {
  const auto& drive = simulatedDrive();
  const auto& frames = drive.frames.at("rear");
  Frame cloud;
  cloud.sensor = Sensor::cloud;
  for (std::size_t i = kFirst; i < kLast; ++i) {
    for (std::size_t k = 0; k < frames[i].cloud.size(); ++k) {
      Point p = frames[i].cloud.points[k];
      p.getVector3fMap() = (T * frames[i].cloud.position(k)).cast<float>();
      cloud.cloud.points.push_back(p);
    }
  }
  const PreprocessedFrame preprocessed = preprocessFrame(std::move(cloud), drive.labels, options);
  Turned turned{makeQuery(&preprocessed, &preprocessed + 1, drive.labels, options), {}};
  turned.truth = drive.sessions.at("rear")->truth(kLast - 1) *
                 frames[kLast - 1].T_odom_sensor.inverse() * T.inverse();
  return turned;
}

Turned turnedGraph(const Eigen::Isometry3d& T, const Options& options) {
  const auto& drive = simulatedDrive();
  SemanticGraph graph = drive.query("rear", kFirst, kLast).graph;
  for (Vertex& v : graph.vertices) v.position = T * v.position;
  Turned turned{makeQuery(graph, drive.labels, options), {}};
  turned.truth = drive.sessions.at("rear")->truth(kLast - 1) *
                 drive.frames.at("rear")[kLast - 1].T_odom_sensor.inverse() * T.inverse();
  return turned;
}

/// Where the last sensor was.
double errorOfTurned(const Localization& fix, const Turned& turned) {
  const Eigen::Vector3d sensor =
      simulatedDrive().sessions.at("rear")->truth(kLast - 1).translation();
  return (fix.T_map_query * (turned.truth.inverse() * sensor) - sensor).norm();
}

TEST(Gravity, OfFramesIsMeasuredWhateverTheirTilt) {
  for (const double degrees : {10.0, 40.0, 90.0, 180.0}) {
    const Eigen::Isometry3d T = turnBy(degrees, 3);
    EXPECT_LT(tiltOf(turnedFrames(T, withGravity("free")).query.gravity.alignment, T), 2)
        << degrees;
    EXPECT_LT(tiltOf(turnedCloud(T, withGravity("free")).query.gravity.alignment, T), 2)
        << degrees << " as a cloud";
    EXPECT_LT(tiltOf(turnedGraph(T, withGravity("free")).query.gravity.alignment, T), 4)
        << degrees << " as a graph";
  }
}

TEST(Gravity, ThatIsAlignedIsLeftAlone) {
  const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
  for (const char* gravity : {"auto", "aligned"}) {
    for (const Query& query : {turnedFrames(none, withGravity(gravity)).query,
                               turnedCloud(none, withGravity(gravity)).query,
                               turnedGraph(none, withGravity(gravity)).query}) {
      EXPECT_FALSE(query.gravity.turned()) << query.gravity.reason;
      EXPECT_TRUE(query.gravity.known);
    }
  }
}

TEST(Gravity, OfAFrameThatStandsAsItsScannerStoodIsLessSure) {
  const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
  const Gravity scanner = turnedCloud(none, withGravity("auto")).query.gravity;
  EXPECT_FALSE(scanner.turned());
  EXPECT_GT(scanner.sigma_rad, Options().refine.tilt_sigma_deg * kDegree);
  EXPECT_LT(scanner.sigma_rad, 4 * kDegree);
  EXPECT_EQ(turnedCloud(none, withGravity("aligned")).query.gravity.sigma_rad, 0);
  EXPECT_EQ(turnedFrames(none, withGravity("auto")).query.gravity.sigma_rad, 0);
}

TEST(Gravity, TurnedQueriesAreFound) {
  const auto& drive = simulatedDrive();
  for (const char* gravity : {"auto", "free"}) {
    const Options options = withGravity(gravity);
    const Localizer localizer(drive.map, options);
    for (const double degrees : {40.0, 180.0}) {
      const Eigen::Isometry3d T = turnBy(degrees, 11);
      for (const auto& [name, turned] : {std::pair("frames", turnedFrames(T, options)),
                                         std::pair("cloud", turnedCloud(T, options))}) {
        const Localization fix = localizer.localize(turned.query);
        EXPECT_EQ(fix.status, Status::accepted)
            << name << " " << degrees << ": " << fix.reason << "; " << fix.gravity_reason;
        EXPECT_EQ(fix.gravity, GravityUse::levelled);
        EXPECT_LT(errorOfTurned(fix, turned), 0.5) << name << " " << degrees;
        EXPECT_LT(rotationBetween(fix.T_map_query, turned.truth), 2 * kDegree)
            << name << " " << degrees;
      }
    }
  }
}

Eigen::Isometry3d tiltedBy(double degrees) {
  return Eigen::Isometry3d(
      Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d(1, 2, 0).normalized()));
}

TEST(Gravity, TiltedQueriesAreLevelledOnTheGroundOfTheMap) {
  const auto& drive = simulatedDrive();
  const Options options;
  const Localizer localizer(drive.map, options);
  for (const double degrees : {3.0, 8.0}) {
    const Turned turned = turnedFrames(tiltedBy(degrees), options);
    EXPECT_FALSE(turned.query.gravity.turned()) << "it may be the slope of a street";
    const Localization fix = localizer.localize(turned.query);
    EXPECT_EQ(fix.status, Status::accepted) << degrees << ": " << fix.reason;
    EXPECT_EQ(fix.gravity, GravityUse::levelled) << degrees;
    EXPECT_LT(errorOfTurned(fix, turned), 0.2) << degrees;
    EXPECT_LT(rotationBetween(fix.T_map_query, turned.truth), 0.3 * kDegree) << degrees;
  }
}

TEST(Gravity, AStreetThatFooledTheMeasurementIsLevelledAllTheSame) {
  const auto& drive = simulatedDrive();
  const Options options;
  const Localizer localizer(drive.map, options);
  Turned turned = turnedFrames(tiltedBy(8), options);
  turned.query.gravity.sigma_rad = kDegree;
  const Localization fix = localizer.localize(turned.query);
  EXPECT_LT(errorOfTurned(fix, turned), 0.2) << fix.gravity_reason;
  EXPECT_LT(rotationBetween(fix.T_map_query, turned.truth), 0.3 * kDegree) << fix.gravity_reason;
}

TEST(Gravity, QueriesWithoutGoodPointsAreLevelledByTheirBev) {
  constexpr double kStepFarAway_rad = 0.3 / 25;  // of the nearest distance class, at the rim
  const auto& drive = simulatedDrive();
  const Options options;
  const Localizer localizer(drive.map, options);
  for (const Eigen::Isometry3d& turn : {tiltedBy(0), tiltedBy(1.5), tiltedBy(8), turnBy(90, 11)}) {
    Turned turned = turnedFrames(turn, options);
    turned.query.cloud.points.clear();
    const Localization fix = localizer.localize(turned.query);
    EXPECT_EQ(fix.status, Status::accepted) << fix.reason;
    EXPECT_LT(errorOfTurned(fix, turned), 0.2) << fix.gravity_reason;
    EXPECT_LT(rotationBetween(fix.T_map_query, turned.truth), kStepFarAway_rad)
        << fix.gravity_reason;
  }
}

TEST(Gravity, ThatIsAlignedByWordIsNotLevelled) {
  const auto& drive = simulatedDrive();
  const Options options = withGravity("aligned");
  const Localization fix =
      Localizer(drive.map, options).localize(turnedFrames(tiltedBy(3), options).query);
  EXPECT_EQ(fix.gravity, GravityUse::aligned);
}

TEST(Gravity, TurnedGraphsAreFoundOrRefused) {
  const auto& drive = simulatedDrive();
  const Options options;
  const map::SemanticMap bare = buildMap(drive.map.graph, drive.labels, "graph", options);
  const Localizer localizer(bare, options);
  int found = 0;
  for (const double degrees : {10.0, 40.0, 90.0, 180.0}) {
    const Turned turned = turnedGraph(turnBy(degrees, 5), options);
    const Localization fix = localizer.localize(turned.query);
    if (!fix.accepted()) continue;
    EXPECT_LT(errorOfTurned(fix, turned), 3) << degrees << ": " << fix.gravity_reason;
    ++found;
  }
  EXPECT_GE(found, 3);
}

/// A wood: trunks of several kinds on rolling ground; no class tells which side of them is up.
SemanticGraph wood(std::size_t count, double side_m, std::uint64_t seed) {
  SemanticGraph graph;
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i) {
    Vertex v;
    v.label = 1 + random.below(5);
    const double x = random.uniform(0, side_m), y = random.uniform(0, side_m);
    v.position = {x, y, 2 * std::sin(x / 30) + random.uniform(-0.5, 0.5)};
    graph.vertices.push_back(v);
  }
  return graph;
}

SemanticGraph partOf(const SemanticGraph& graph, const Eigen::Vector2d& middle, double radius_m,
                     const Eigen::Isometry3d& T) {
  SemanticGraph part;
  for (Vertex v : graph.vertices) {
    if ((v.position.head<2>() - middle).norm() > radius_m) continue;
    v.position = T * v.position;
    part.vertices.push_back(v);
  }
  return part;
}

TEST(Gravity, ThatNothingTellsIsFoundWithThePose) {
  const LabelSet labels = genericLabelSet({1, 2, 3, 4, 5});
  const SemanticGraph graph = wood(600, 400, 3);
  const map::SemanticMap map = buildMap(graph, labels, "wood", {});
  for (const char* method : {"auto", "walks"}) {
    Options options;
    options.method = method;
    const Localizer localizer(map, options);
    for (const double degrees : {60.0, 90.0, 150.0}) {
      const Eigen::Isometry3d T = turnBy(degrees, 21);
      const Query query = makeQuery(partOf(graph, {200, 180}, 60, T), labels, options);
      EXPECT_FALSE(query.gravity.known) << query.gravity.reason;
      const Localization fix = localizer.localize(query);
      EXPECT_EQ(fix.status, Status::accepted) << method << " " << degrees << ": " << fix.reason;
      EXPECT_LT((fix.T_map_query * T * Eigen::Vector3d(200, 180, 0) - Eigen::Vector3d(200, 180, 0))
                    .norm(),
                1)
          << method << " " << degrees;
      EXPECT_LT(rotationBetween(fix.T_map_query, T.inverse()), 3 * kDegree)
          << method << " " << degrees;
      if (query.gravity.known) continue;
      EXPECT_EQ(fix.gravity, method == std::string("auto") ? GravityUse::free : fix.gravity);
    }
  }
}

TEST(Gravity, ThatNothingTellsFindsNoOtherWorld) {
  const LabelSet labels = genericLabelSet({1, 2, 3, 4, 5});
  const map::SemanticMap map = buildMap(wood(600, 400, 3), labels, "wood", {});
  const Localizer localizer(map, {});
  for (const std::uint64_t seed :
       {104, 105, 106, 108, 109}) {  // not the map's stream shifted by whole vertices
    const Query query =
        makeQuery(partOf(wood(600, 400, seed), {200, 180}, 60, turnBy(90, seed)), labels, {});
    const Localization fix = localizer.localize(query);
    EXPECT_NE(fix.status, Status::accepted) << fix.reason;
  }
}

TEST(Gravity, FlatWorldsAreNotFoundInTheirMirrorImage) {
  const LabelSet labels = genericLabelSet({1, 2, 3, 4, 5});
  SemanticGraph flat = wood(600, 400, 3);
  for (Vertex& v : flat.vertices) v.position.z() = 0;
  const map::SemanticMap map = buildMap(flat, labels, "flat", {});
  const Eigen::Isometry3d over(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  const Query query = makeQuery(partOf(flat, {200, 180}, 60, over), labels, withGravity("free"));
  const Localization fix = Localizer(map, withGravity("free")).localize(query);
  ASSERT_EQ(fix.status, Status::accepted) << fix.reason;
  EXPECT_LT(rotationBetween(fix.T_map_query, over), 2 * kDegree);
  const Query aligned =
      makeQuery(partOf(flat, {200, 180}, 60, over), labels, withGravity("aligned"));
  EXPECT_NE(Localizer(map, withGravity("aligned")).localize(aligned).status, Status::accepted)
      << "z is up by order";
}

TEST(Gravity, OfNothingIsNotKnown) {
  EXPECT_FALSE(gravityOf(std::vector<PlaceBuilder::SharedFrame>(), {}, "free").known);
  EXPECT_TRUE(gravityOf(std::vector<PlaceBuilder::SharedFrame>(), {}, "auto").known);
  EXPECT_FALSE(gravityOf(SemanticGraph(), {}, "free").known);
  SemanticGraph line;
  for (int i = 0; i < 20; ++i) {
    Vertex v;
    v.label = 1;
    v.position = {1.0 * i, 0, 0};
    line.vertices.push_back(v);
  }
  EXPECT_EQ(layerNormal(line).norm(), 0) << "a line lies in many planes";
}

}  // namespace
}  // namespace xview
