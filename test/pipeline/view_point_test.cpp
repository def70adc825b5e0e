// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/view_point.h"

#include <gtest/gtest.h>

#include "xview/types/pose.h"
#include "xview/types/random.h"

namespace xview {
namespace {

/// A cloud of a square of 20 m around a point, with a vertex in each corner.
Query squareAround(double x, double y) {
  Query query;
  query.poses = {Eigen::Isometry3d::Identity()};
  for (const double dx : {-10., 10.}) {
    for (const double dy : {-10., 10.}) {
      Vertex vertex;
      vertex.position = {x + dx, y + dy, 3};
      query.graph.vertices.push_back(vertex);
      Point point;
      point.getVector3fMap() = vertex.position.cast<float>();
      query.cloud.points.push_back(point);
    }
  }
  return query;
}

TEST(ViewPoint, IsTheOriginOfAScanAndTheCentreOfACloudFarFromIt) {
  EXPECT_FALSE(seenFromItsCentre(squareAround(5, -4)));
  const auto centred = seenFromItsCentre(squareAround(500, -40));
  ASSERT_TRUE(centred);
  ASSERT_EQ(centred->poses.size(), 1u);
  EXPECT_TRUE(centred->poses[0].translation().isApprox(Eigen::Vector3d(500, -40, 3)));
}

TEST(ViewPoint, OfADriveIsWhereItsSensorWas) {
  Query drive = squareAround(500, -40);
  drive.sensor = Sensor::camera;
  EXPECT_FALSE(seenFromItsCentre(drive));
  drive.sensor = Sensor::lidar;
  EXPECT_FALSE(seenFromItsCentre(drive));
}

TEST(ViewPoint, ThatSeesNothingStays) {
  Query nothing;
  nothing.poses = {Eigen::Isometry3d::Identity()};
  EXPECT_FALSE(seenFromItsCentre(nothing));
}

TEST(MovedCovariance, IsThatOfTheMovedPoint) {
  Random random(3);
  const auto vector = [&](double size) -> Eigen::Vector3d {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return size * Eigen::Vector3d(x, y, z);
  };
  const Eigen::Vector3d from = vector(10), to = vector(300);
  Matrix6d covariance = Matrix6d::Zero();
  Eigen::Matrix3d moved = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 500;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d shift = vector(0.1), turn = vector(1e-4);
    Eigen::Matrix<double, 6, 1> error;
    error << shift, turn;
    covariance += error * error.transpose() / kDraws;
    const Eigen::AngleAxisd R(turn.norm(), turn.normalized());
    const Eigen::Vector3d error_there = from + shift + R * (to - from) - to;
    moved += error_there * error_there.transpose() / kDraws;
  }
  const Matrix6d there = movedCovariance(covariance, from, to);
  EXPECT_LT((there.topLeftCorner<3, 3>() - moved).norm(), 1e-3 * moved.norm());
  EXPECT_TRUE((there.bottomRightCorner<3, 3>()).isApprox(covariance.bottomRightCorner<3, 3>()));
}

}  // namespace
}  // namespace xview
