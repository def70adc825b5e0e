// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_in_map.h"

#include <gtest/gtest.h>

#include "base/user_text.h"
#include "localizer/simulated_drive.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::simulatedDrive;

Options withScale(const std::string& scale) {
  Options options;
  options.scale = scale;
  return options;
}

double errorOfScaled(const Localization& fix, std::size_t last_frame) {
  return (fix.T_map_sensor.translation() -
          simulatedDrive().sessions.at("rear")->truth(last_frame).translation())
      .norm();
}

TEST(ScaleSearch, FindsTheScaleOfTheQueryWithItsPlace) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, withScale("free"));
  for (const double factor : {0.8, 0.9, 1.0, 1.1, 1.25}) {
    const Query query = scaledQuery(drive.query("rear", 10, 40), factor);
    const Localization fix = localizer.localize(query);
    EXPECT_EQ(fix.status, Status::accepted) << factor << ": " << fix.reason;
    EXPECT_NEAR(fix.scale * factor, 1, 0.015) << factor;
    EXPECT_LT(errorOfScaled(fix, 39), 0.5) << factor;
    // The pose is that of the query with all lengths multiplied.
    Eigen::Isometry3d last = query.poses.back();
    last.translation() *= fix.scale;
    EXPECT_TRUE((fix.T_map_query * last).isApprox(fix.T_map_sensor, 1e-9));
  }
}

TEST(ScaleSearch, WithoutItAWrongScaleIsNeverAWrongAcceptedPose) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, {});
  const Localization right = localizer.localize(drive.query("rear", 10, 40));
  EXPECT_EQ(right.status, Status::accepted) << "else nothing is tried here: " << right.reason;
  for (const double factor : {0.8, 1.25}) {
    const Localization fix = localizer.localize(scaledQuery(drive.query("rear", 10, 40), factor));
    EXPECT_EQ(fix.scale, 1);
    EXPECT_FALSE(fix.hypotheses.empty()) << factor;
    if (fix.accepted()) {
      EXPECT_LT(errorOfScaled(fix, 39), 5) << factor;
    }
  }
}

TEST(ScaleSearch, FindsAGraphInAGraph) {
  const auto& drive = simulatedDrive();
  const map::SemanticMap bare = buildMap(drive.map.graph, drive.labels, "graph", {});
  const Query right = makeQuery(drive.query("rear", 5, 45).graph, drive.labels, {});
  const Eigen::Isometry3d truth = Localizer(bare, {}).localize(right).T_map_query;
  const Localization fix =
      Localizer(bare, withScale("0.8,1.25")).localize(scaledQuery(right, 1.15));
  EXPECT_NEAR(fix.scale * 1.15, 1, 0.03) << fix.reason;
  const Eigen::Vector3d p = right.graph.vertices[0].position;
  EXPECT_LT((fix.T_map_query * (fix.scale * 1.15 * p) - truth * p).norm(), 2);
}

TEST(ScaleSearch, AcceptsNothingFromElsewhere) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, withScale("free"));
  for (std::size_t first = 0; first + 30 <= drive.frames.at("elsewhere").size(); first += 30) {
    const Localization fix = localizer.localize(drive.query("elsewhere", first, first + 30));
    EXPECT_NE(fix.status, Status::accepted) << fix.reason;
  }
}

TEST(ScaleSearch, StaysInItsRange) {
  const auto& drive = simulatedDrive();
  const Localization fix = Localizer(drive.map, withScale("0.95,1.05"))
                               .localize(scaledQuery(drive.query("rear", 10, 40), 1.25));
  EXPECT_GE(fix.scale, 0.95);
  EXPECT_LE(fix.scale, 1.05);
}

TEST(ScaleSearch, OfAnEmptyQueryIsRejected) {
  const auto& drive = simulatedDrive();
  Query empty;
  empty.labels = drive.labels;
  empty.poses.push_back(Eigen::Isometry3d::Identity());
  EXPECT_EQ(Localizer(drive.map, withScale("free")).localize(empty).status, Status::rejected);
}

TEST(ScaleSearch, RefusesWhatIsNoRange) {
  for (const char* text : {"1", "a,b", "1.2,0.8", "0,1", "1,2,3", "fre"})
    EXPECT_THROW(parseScale("--scale", text), UsageError) << text;
  EXPECT_FALSE(parseScale("--scale", ""));
  EXPECT_EQ(parseScale("--scale", "0.9,1.2")->high, 1.2);
  Options walks = withScale("free");
  walks.method = "walks";
  EXPECT_THROW(
      Localizer(simulatedDrive().map, walks).localize(simulatedDrive().query("rear", 0, 10)),
      UsageError);
}

}  // namespace
}  // namespace xview
