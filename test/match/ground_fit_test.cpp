// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/match/ground_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "xview/types/random.h"

namespace xview::test {
namespace {

constexpr double kSlopeX = 0.03, kSlopeY = -0.05, kHeight_m = 2.5;  // map against query
constexpr double kLevel = 0.2;

double roadHeight(double x, double y) { return 0.4 * std::sin(x / 9) + 0.3 * std::cos(y / 7); }

/// A map whose ground was measured within `half_width_m` of the x axis.
PlanField hillyMap(double half_width_m) {
  PlanView map;
  for (int cy = -80; cy < 80; ++cy) {
    for (int cx = -120; cx < 120; ++cx) {
      const double x = (cx + 0.5) * map.cell_m, y = (cy + 0.5) * map.cell_m;
      if (std::abs(y) > half_width_m) continue;
      map.known.push_back({cx, cy, static_cast<float>(roadHeight(x, y)), true});
    }
  }
  return PlanField(map, 1);
}

/// The same ground as a query has it that lies at `pose`, tilted and lowered.
std::vector<PlanQuery::Ground> tiltedGround(const PlacePose& pose, double noise_m,
                                            double wrong_share) {
  Random random(4);
  std::vector<PlanQuery::Ground> ground;
  for (int i = 0; i < 600; ++i) {
    const double qx = random.uniform(-25, 25), qy = random.uniform(-25, 25);
    const double x = std::cos(pose.yaw) * qx - std::sin(pose.yaw) * qy,
                 y = std::sin(pose.yaw) * qx + std::cos(pose.yaw) * qy;
    double z = roadHeight(pose.x + x, pose.y + y) - kHeight_m - kSlopeX * x - kSlopeY * y +
               noise_m * random.normal();
    if (random.uniform() < wrong_share) z += random.uniform(1, 6);
    ground.push_back({static_cast<float>(qx), static_cast<float>(qy), static_cast<float>(z)});
  }
  return ground;
}

TEST(FitGround, FindsTheSlopeBetweenQueryAndMap) {
  const PlanField field = hillyMap(40);
  const PlacePose pose{3, -2, 1.1, 0};
  const GroundFit fit = fitGround(field, tiltedGround(pose, 0.02, 0), pose, kLevel);
  EXPECT_NEAR(fit.height_m, kHeight_m, 0.02);
  EXPECT_NEAR(fit.slope.x(), kSlopeX, 0.002);
  EXPECT_NEAR(fit.slope.y(), kSlopeY, 0.002);
  EXPECT_GT(fit.cells, 400);
}

TEST(FitGround, PassesOverThingsThatAreNoGround) {
  const PlanField field = hillyMap(40);
  const PlacePose pose{3, -2, 1.1, 0};
  const GroundFit fit = fitGround(field, tiltedGround(pose, 0.05, 0.3), pose, kLevel);
  EXPECT_NEAR(fit.height_m, kHeight_m, 0.05);
  EXPECT_NEAR(fit.slope.x(), kSlopeX, 0.004);
  EXPECT_NEAR(fit.slope.y(), kSlopeY, 0.004);
}

TEST(FitGround, IsLessSureAcrossANarrowStreetThanAlongIt) {
  const PlacePose pose{3, 0, 0, 0};
  const GroundFit fit = fitGround(hillyMap(4), tiltedGround(pose, 0.05, 0), pose, kLevel);
  ASSERT_GT(fit.cells, 0);
  EXPECT_GT(fit.covariance(2, 2), 4 * fit.covariance(1, 1));
}

TEST(FitGround, LeavesAQueryLevelThatIsSurelyLevel) {
  const PlacePose pose{3, 0, 0, 0};
  const GroundFit sure = fitGround(hillyMap(40), tiltedGround(pose, 0.05, 0), pose, 1e-5);
  EXPECT_NEAR(sure.slope.norm(), 0, 1e-3);
  const GroundFit to_a_quarter_of_a_degree =
      fitGround(hillyMap(40), tiltedGround(pose, 0.05, 0), pose, 4e-3);
  EXPECT_NEAR(to_a_quarter_of_a_degree.slope.norm(), 0, 4e-3);
}

TEST(FitGround, SaysNothingWithoutCommonGround) {
  const PlacePose far{500, 0, 0, 0};
  EXPECT_EQ(fitGround(hillyMap(40), tiltedGround({}, 0.05, 0), far, kLevel).cells, 0);
  EXPECT_EQ(fitGround(hillyMap(40), {}, {}, kLevel).cells, 0);
}

/// A flat map at a height of 7 m that was seen, but whose ground was not.
PlanField mapOfThingsOnly() {
  PlanView map;
  for (int cy = -80; cy < 80; ++cy) {
    for (int cx = -80; cx < 80; ++cx) map.known.push_back({cx, cy, 7, false});
  }
  return PlanField(map, 1);
}

PlanQuery queryOfThingsOnly() {
  PlanQuery query;
  for (int i = 0; i < 20; ++i)
    query.fine.push_back(
        {static_cast<float>(i), 3, static_cast<std::uint8_t>(Channel::pole), WaySide::none, -4});
  return query;
}

TEST(HeightOffset, ComesFromMeasuredGroundWhereBothKnowIt) {
  PlanQuery query = queryOfThingsOnly();
  const PlacePose pose{3, -2, 1.1, 0};
  query.ground = tiltedGround(pose, 0, 0);
  EXPECT_NEAR(heightOffset(hillyMap(40), query, pose), kHeight_m, 0.1);
}

TEST(HeightOffset, ComesFromWhatStandsAroundWhereNoGroundWasMeasured) {
  EXPECT_NEAR(heightOffset(mapOfThingsOnly(), queryOfThingsOnly(), {1, 2, 0.4, 0}), 11, 1e-6);
}

TEST(HeightOffset, IsZeroWhereNothingMeets) {
  EXPECT_EQ(heightOffset(mapOfThingsOnly(), queryOfThingsOnly(), {5000, 0, 0, 0}), 0);
  EXPECT_EQ(heightOffset(mapOfThingsOnly(), {}, {}), 0);
}

}  // namespace
}  // namespace xview::test
