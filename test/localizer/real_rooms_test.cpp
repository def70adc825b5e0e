// SPDX-License-Identifier: BSD-3-Clause
// Recorded rooms without labels, in frames that have nothing to do with one another.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "base/pose.h"
#include "support/test_data.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/mapper.h"

namespace xview {
namespace {

/// T_map_query of a file of 12 or 16 numbers, row by row, with comments.
Eigen::Isometry3d truthIn(const std::string& path) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  std::ifstream file(path);
  for (int i = 0; i < 12; ++i) {
    while (file >> std::ws && file.peek() == '#') file.ignore(10000, '\n');
    file >> T.matrix()(i / 4, i % 4);
  }
  EXPECT_TRUE(file) << path;
  return T;
}

Localization answerTo(const std::string& query, const std::string& map) {
  const auto map_cloud = io::openRecording(map), cloud = io::openRecording(query);
  const Options options;
  return Localizer(buildMap(*map_cloud, options), options).localize(*cloud);
}

struct RoomPair {
  const char *name, *folder, *map, *query, *truth;
  double most_m;
};

class RealRoomPairs : public testing::TestWithParam<RoomPair> {};

TEST_P(RealRoomPairs, AreAccepted) {
  const RoomPair& pair = GetParam();
  XVIEW_REQUIRE_DATA(data, pair.folder);
  const std::string folder = data + "/";
  const Localization answer = answerTo(folder + pair.query, folder + pair.map);
  EXPECT_EQ(answer.status, Status::accepted) << answer.reason;
  const Eigen::Isometry3d truth = truthIn(folder + pair.truth);
  const Eigen::Vector3d sensor = truth.inverse() * answer.T_map_sensor.translation();
  EXPECT_LT((answer.T_map_query * sensor - truth * sensor).norm(), pair.most_m);
  EXPECT_LT(rotationBetween(answer.T_map_query, truth), 3 * M_PI / 180);
}

INSTANTIATE_TEST_SUITE_P(OfClouds, RealRoomPairs,
                         testing::Values(RoomPair{"Apartment", "apartment", "map.pcd", "query.pcd",
                                                  "query_truth.txt", 0.05},
                                         RoomPair{"Corridor", "tls_corridor", "map.pcd",
                                                  "query_2.pcd", "query_2_truth.txt", 0.1},
                                         RoomPair{"Kitchen", "kitchen", "map.ply", "query_4.ply",
                                                  "query_4_truth.txt", 0.1}),
                         [](const auto& pair) { return std::string(pair.param.name); });

/// The hand of a frame mistaken, as of 3DTK's files: another place.
TEST(RealRooms, AreRefusedInAMirror) {
  XVIEW_REQUIRE_DATA(data, "tls_corridor");
  EXPECT_NE(answerTo(data + "/query_2_left_handed.pcd", data + "/map.pcd").status,
            Status::accepted);
  const Localization twin = answerTo(data + "/query_1_left_handed.pcd", data + "/query_1.pcd");
  EXPECT_NE(twin.status, Status::accepted) << twin.reason;
  EXPECT_NE(twin.reason.find("mirror"), std::string::npos) << twin.reason;
}

TEST(RealRooms, AreRefusedInOneAnother) {
  XVIEW_REQUIRE_DATA(kitchen, "kitchen");
  XVIEW_REQUIRE_DATA(apartment, "apartment");
  EXPECT_NE(answerTo(kitchen + "/query_g.pcd", apartment + "/map.pcd").status, Status::accepted);
}

}  // namespace
}  // namespace xview
