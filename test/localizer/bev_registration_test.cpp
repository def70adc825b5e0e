// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/pose_refinement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/pose.h"
#include "base/random.h"

namespace xview {
namespace {

/// Two fronts at right angles, a kerb with a bend and some poles, sampled every half metre.
BevGrid town() {
  BevGrid view;
  view.origin_x = 640;
  view.origin_y = -128;
  for (float t = -20; t <= 20; t += 0.5F) {
    view[BevChannel::building].push_back({t, 9, 0});
    view[BevChannel::building].push_back({-14, t, 0});
    view[BevChannel::border_road_sidewalk].push_back({t, 4 + 0.002F * t * t, 0});
    view[BevChannel::road].push_back({t, 0, 0});
  }
  for (const float t : {-15.F, -4.F, 6.F, 13.F}) view[BevChannel::pole].push_back({t, 5, 0});
  return view;
}

/// The same place seen by a query: each sample where T_query_map puts it, with an error; areas are
/// wherever they like.
BevGrid seenBy(const BevGrid& map, const Eigen::Isometry3d& T_query_map, double sigma_m) {
  BevGrid view;
  Random random(5);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    for (const BevSample& s : map.samples[c]) {
      const Eigen::Vector3d p =
          T_query_map * Eigen::Vector3d(map.origin_x + s.x, map.origin_y + s.y, 0);
      const double off = isArea(static_cast<BevChannel>(c)) ? 3 : 0;
      view.samples[c].push_back({static_cast<float>(p.x() + off + sigma_m * random.normal()),
                                 static_cast<float>(p.y() + off + sigma_m * random.normal()), 0});
    }
  }
  return view;
}

const Eigen::Isometry3d kTruth = poseFromYaw({655, -140, 7}, 2.5);  ///< T_map_query

Eigen::Isometry3d sensorInQuery() {
  Eigen::Isometry3d sensor = kTruth.inverse();
  sensor.translation() = kTruth.inverse() * Eigen::Vector3d(641, -126, 40);
  return sensor;
}

double errorOfShift(const Eigen::Isometry3d& T_map_query) {
  const Eigen::Vector3d sensor = sensorInQuery().translation();
  return (T_map_query * sensor - kTruth * sensor).norm();
}

/// T_map_query, with the sensor this far off and the query turned about it.
Eigen::Isometry3d disturbed(const Eigen::Vector3d& shift, double turn) {
  const Eigen::Vector3d sensor = kTruth * sensorInQuery().translation();
  return Eigen::Translation3d(sensor + shift) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
         Eigen::Translation3d(-sensor) * kTruth;
}

TEST(BevRegistration, FindsThePoseBetweenTheCells) {
  const BevGrid map = town();
  const BevRegistration registration(map);
  const BevGrid query = seenBy(map, kTruth.inverse(), 0.2);
  for (const Eigen::Vector3d& shift :
       {Eigen::Vector3d(0.4, 0.3, 0), Eigen::Vector3d(-0.6, 0.2, 0)}) {
    for (const double turn : {-0.02, 0.015}) {
      const auto T =
          registration.align(query, sensorInQuery().translation(), disturbed(shift, turn));
      ASSERT_TRUE(T.has_value());
      EXPECT_LT(errorOfShift(T->T_map_query), 0.12);
      EXPECT_LT(std::abs(angleDifference(yawOf(T->T_map_query.linear()), yawOf(kTruth.linear()))),
                0.006);
    }
  }
}

TEST(BevRegistration, MovesInThePlaneOnly) {
  const BevGrid map = town();
  const Eigen::Isometry3d tilt(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()));
  const Eigen::Isometry3d start = disturbed({0.3, 0.3, 2}, 0) * tilt;
  const BevGrid query = seenBy(map, kTruth.inverse(), 0.1);
  const auto T = BevRegistration(map).align(query, sensorInQuery().translation(), start);
  ASSERT_TRUE(T.has_value());
  EXPECT_NEAR(T->T_map_query.translation().z(), start.translation().z(), 1e-9);
  EXPECT_NEAR((T->T_map_query.linear() * start.linear().transpose())(2, 2), 1, 1e-12);
}

TEST(BevRegistration, DoesNotDependOnTheFrameOfTheQueryNorOnWhichWayIsUpInIt) {
  const BevGrid map = town();
  const BevGrid query = seenBy(map, kTruth.inverse(), 0.2);
  const Eigen::Isometry3d start = disturbed({0.4, -0.3, 0}, 0.01);
  const Eigen::Vector3d sensor = sensorInQuery().translation();
  const auto T = BevRegistration(map).align(query, sensor, start);
  BevGrid tilted = query;
  tilted.alignment = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  const Eigen::Isometry3d upright(tilted.alignment);
  const auto other =
      BevRegistration(map).align(tilted, upright.inverse() * sensor, start * upright);
  ASSERT_TRUE(T.has_value() && other.has_value());
  EXPECT_TRUE(
      (T->T_map_query.matrix() - (other->T_map_query * upright.inverse()).matrix()).isZero(1e-6));
}

TEST(BevRegistration, HasNoAnswerWhereNothingIsAlike) {
  const BevGrid map = town();
  const Eigen::Vector3d sensor = sensorInQuery().translation();
  EXPECT_FALSE(BevRegistration(map).align(BevGrid(), sensor, kTruth).has_value());
  const BevGrid query = seenBy(map, kTruth.inverse(), 0.1);
  EXPECT_FALSE(BevRegistration(BevGrid()).align(query, sensor, kTruth).has_value());
  EXPECT_FALSE(BevRegistration(map).align(query, sensor, disturbed({200, 0, 0}, 0)).has_value());
}

}  // namespace
}  // namespace xview
