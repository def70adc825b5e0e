// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/pose.h"
#include "base/random.h"
#include "search/search.h"

namespace xview {
namespace {

Query lidarQuery(const Eigen::Isometry3d& last) {
  Query query;
  query.sensor = Sensor::lidar;
  query.poses = {last};
  return query;
}

TEST(PosePrior, EveryPoseThatSatisfiesItPutsOtherPointsWhereItSays) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Isometry3d last =
        poseFromYaw({random.uniform(-50, 50), random.uniform(-50, 50), 1}, random.uniform(-3, 3));
    const Query query = lidarQuery(last);
    PlacePrior prior;
    prior.near = PlacePrior::Circle{random.uniform(-100, 100), random.uniform(-100, 100),
                                    random.uniform(0.5, 30)};
    if (i % 3 > 0)
      prior.heading =
          PlacePrior::Heading{random.uniform(-3, 3), random.uniform(0.05, i % 3 == 1 ? 0.5 : 4)};
    const Eigen::Vector2d point = last.translation().head<2>() +
                                  Eigen::Vector2d(random.uniform(-40, 40), random.uniform(-40, 40));
    const PlacePrior of_point =
        search::priorOfPoint(ofQueryFrame({prior}, query), point - last.translation().head<2>());

    const double direction = random.uniform(-M_PI, M_PI),
                 off = prior.near->radius * std::sqrt(random.uniform());
    const double yaw = prior.heading
                           ? prior.heading->yaw + random.uniform(-1, 1) * prior.heading->tolerance
                           : random.uniform(-M_PI, M_PI);
    const Eigen::Isometry3d T_map_sensor = poseFromYaw(
        {prior.near->x + off * std::cos(direction), prior.near->y + off * std::sin(direction), 1},
        yaw);
    const Eigen::Isometry3d T_map_query = T_map_sensor * last.inverse();
    ASSERT_TRUE(satisfies({prior}, query.sensor, T_map_query * query.poses.back()));
    const Eigen::Vector3d p = T_map_query * Eigen::Vector3d(point.x(), point.y(), 1);
    EXPECT_LE(std::hypot(p.x() - of_point.near->x, p.y() - of_point.near->y),
              of_point.near->radius + 1e-9)
        << i;
    if (prior.heading) {
      EXPECT_LE(std::abs(angleDifference(yawOf(T_map_query.linear()), of_point.heading->yaw)),
                of_point.heading->tolerance + 1e-9);
    }
  }
}

TEST(PosePrior, AKnownHeadingMakesTheCircleOfAPointSmaller) {
  const PlacePrior::Circle circle{10, 0, 5};
  const PlacePrior any = search::priorOfPoint({{circle, std::nullopt}}, {-30, 0});
  const PlacePrior known = search::priorOfPoint({{circle, PlacePrior::Heading{0, 0.1}}}, {-30, 0});
  EXPECT_DOUBLE_EQ(any.near->radius, 35);
  EXPECT_LT(known.near->radius, 8.1);
  EXPECT_DOUBLE_EQ(known.near->x, -20);
}

TEST(PosePrior, OfSeveralTheNarrowestCounts) {
  const Query query = lidarQuery(Eigen::Isometry3d::Identity());
  const Priors priors{{PlacePrior::Circle{0, 0, 50}, PlacePrior::Heading{0, 0.1}},
                      {PlacePrior::Circle{3, 0, 5}, PlacePrior::Heading{0, 1}}};
  const PlacePrior both = search::priorOfPoint(priors, {0, 0});
  EXPECT_EQ(both.near->radius, 5);
  EXPECT_EQ(both.heading->tolerance, 0.1);
  EXPECT_TRUE(satisfies(priors, query.sensor, poseFromYaw({4, 0, 0}, 0.05)));
  EXPECT_FALSE(satisfies(priors, query.sensor, poseFromYaw({4, 0, 0}, 0.5)));
  EXPECT_FALSE(satisfies(priors, query.sensor, poseFromYaw({-4, 0, 0}, 0.05)));
}

TEST(PosePrior, ACameraThatLooksStraightDownHasTheHeadingOfTheTopOfItsImage) {
  Query query = lidarQuery(Eigen::Isometry3d::Identity());
  query.sensor = Sensor::camera;
  query.poses.back().linear() << 0, -1, 0, -1, 0, 0, 0, 0,
      -1;  // image right = -y, image down = -x: its top shows +x
  const PlacePrior along_x{std::nullopt, PlacePrior::Heading{0, 0.2}};
  const Eigen::Isometry3d& T_query_sensor = query.poses.back();
  EXPECT_TRUE(satisfies({along_x}, query.sensor, T_query_sensor));
  EXPECT_FALSE(satisfies({along_x}, query.sensor, poseFromYaw({0, 0, 0}, 0.5) * T_query_sensor));
}

}  // namespace
}  // namespace xview
