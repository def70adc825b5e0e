// SPDX-License-Identifier: BSD-3-Clause
// Buildings of simulated offices, one above the other.
#include "localizer/storeys_of_map.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/recordings.h"
#include "xview/localizer.h"
#include "xview/mapper.h"
#include "xview/sequence.h"

namespace xview {
namespace {

constexpr double kHeight_m = 3.2;
constexpr std::size_t kFirst = 255, kMiddle = 285, kLast = 315;  ///< frames of queries

/// Walks through an office: the mapping walk, and one that looks back.
std::map<std::string, std::unique_ptr<SimulatedRecording>> officeOf(int seed) {
  SimulationOptions simulation;
  simulation.seed = seed;
  simulation.sim.style = "office";
  simulation.route_length_m = 60;
  simulation.width = 200;
  simulation.height = 150;
  simulation.sessions.aerial = false;
  std::map<std::string, std::unique_ptr<SimulatedRecording>> sessions;
  for (auto& session : makeSessions(simulation)) sessions[session->name()] = std::move(session);
  return sessions;
}

/// Brings a walk onto a floor of the building, along its x axis.
Eigen::Isometry3d onFloor(int floor, const FrameSource& walk) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < walk.size(); ++i)
    middle += walk.pose(i).translation() / static_cast<double>(walk.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < walk.size(); ++i) {
    const Eigen::Vector2d d = (walk.pose(i).translation() - middle).head<2>();
    scatter += d * d.transpose();
  }
  const Eigen::Vector2d along =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  const Eigen::AngleAxisd turn(-std::atan2(along.y(), along.x()), Eigen::Vector3d::UnitZ());
  return Eigen::Translation3d(0, 0, floor * kHeight_m) * turn * Eigen::Translation3d(-middle);
}

Options ofRooms() {
  Options options;
  options.size = "room";
  return options;
}

/// Of these walks, from below, about one vertical axis.
map::SemanticMap buildingOf(const std::vector<const FrameSource*>& walks) {
  std::vector<std::unique_ptr<PosedRecording>> floors;
  std::vector<const FrameSource*> sources;
  for (const FrameSource* walk : walks) {
    floors.push_back(
        std::make_unique<PosedRecording>(*walk, onFloor(static_cast<int>(floors.size()), *walk)));
    sources.push_back(floors.back().get());
  }
  return buildMap(sources, ofRooms());
}

class Buildings : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    office_ = officeOf(11);
    const auto another = officeOf(12);
    const FrameSource &walk = *office_.at("forward"), &elsewhere = *another.at("forward");
    other_ = std::make_unique<map::SemanticMap>(buildingOf({&elsewhere, &walk}));
    same_ = std::make_unique<map::SemanticMap>(buildingOf({&walk, &walk, &walk}));
  }
  static void TearDownTestSuite() { other_.reset(), same_.reset(), office_.clear(); }

  static Query seen(std::size_t first, std::size_t last) {
    const FrameSource& rear = *office_.at("rear");
    std::vector<PreprocessedFrame> frames;
    for (std::size_t i = first; i < last; ++i)
      frames.push_back(preprocessFrame(rear.read(i), rear.labels(), ofRooms()));
    return makeQuery(frames.data(), frames.data() + frames.size(), rear.labels(), ofRooms());
  }
  /// Where the last frame of the queries is, if they were on that floor.
  static Eigen::Isometry3d truthOn(int floor) {
    return onFloor(floor, *office_.at("forward")) * office_.at("rear")->truth(kLast - 1);
  }
  static double errorOf(const Localization& fix, int floor) {
    return (fix.T_map_sensor.translation() - truthOn(floor).translation()).norm();
  }

  static std::map<std::string, std::unique_ptr<SimulatedRecording>> office_;
  static std::unique_ptr<map::SemanticMap> other_, same_;
};
std::map<std::string, std::unique_ptr<SimulatedRecording>> Buildings::office_;
std::unique_ptr<map::SemanticMap> Buildings::other_, Buildings::same_;

TEST_F(Buildings, AreFoundOnTheFloorWhereTheyLookSo) {
  const Localization fix = Localizer(*other_, ofRooms()).localize(seen(kFirst, kLast));
  EXPECT_TRUE(fix.accepted()) << fix.reason;
  EXPECT_LT(errorOf(fix, 1), 0.1);
}

TEST_F(Buildings, OfFloorsThatAreAlikeAreAmbiguousAndNameThem) {
  const Localization fix = Localizer(*same_, ofRooms()).localize(seen(kFirst, kLast));
  EXPECT_EQ(fix.status, Status::ambiguous) << fix.reason;
  EXPECT_NE(fix.reason.find(" of 3, "), std::string::npos) << fix.reason;
  EXPECT_NE(fix.reason.find(" m apart in height"), std::string::npos) << fix.reason;
}

/// Who was on a floor is on it a window later.
TEST_F(Buildings, KeepTheFloorOfAnExpectedPose) {
  const Localizer localizer(*same_, ofRooms());
  const Query query = seen(kFirst, kLast);
  for (int floor = 0; floor < 3; ++floor) {
    ExpectedPose expected;
    expected.T_map_query = truthOn(floor) * office_.at("rear")->pose(kLast - 1).inverse();
    expected.radius_m = 1;
    expected.yaw_rad = 0.1;
    const Localization fix = localizer.localize(query, expected);
    EXPECT_TRUE(fix.accepted()) << fix.reason;
    EXPECT_LT(errorOf(fix, floor), 0.1);
  }
}

TEST_F(Buildings, AreFoundInASequenceAsOnePlaceIs) {
  const Localizer localizer(*other_, ofRooms());
  Sequence sequence(localizer, ofRooms());
  sequence.add(seen(kFirst, kMiddle), kFirst, kMiddle);
  const SequenceAnswer answer = sequence.add(seen(kMiddle, kLast), kMiddle, kLast);
  EXPECT_EQ(answer.windows, 2);
  EXPECT_TRUE(answer.fix.accepted()) << answer.fix.reason;
  EXPECT_LT(errorOf(answer.fix, 1), 0.1);
}

TEST_F(Buildings, HaveStoreysWithWhatTheyHold) {
  map::SemanticMap canonical = *other_;
  scaleLengths(1 / canonical.size, canonical);
  const std::vector<StoreyOfMap> storeys = storeysOf(canonical);
  ASSERT_EQ(storeys.size(), 2U);
  EXPECT_NEAR(storeys[1].bottom * kRoomScale, kHeight_m - 1.5, 0.5);
  std::size_t vertices = 0, points = 0;
  for (const StoreyOfMap& storey : storeys) {
    EXPECT_GT(storey.map.poses.size(), 10U);
    EXPECT_GT(storey.map.bev.sampleCount(), 1000U);
    vertices += storey.map.graph.size();
    points += storey.map.cloud.size();
  }
  EXPECT_EQ(vertices, canonical.graph.size());
  EXPECT_EQ(points, canonical.cloud.size());
}

}  // namespace
}  // namespace xview
