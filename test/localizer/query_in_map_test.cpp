// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/query_in_map.h"

#include "localizer/query_check.h"

#include <gtest/gtest.h>

#include <tuple>

#include "base/random.h"
#include "place/sound_input.h"
#include "pose/trajectory.h"

namespace xview {
namespace {

/// The BEV grid of a query that is turned by so much.
BevGrid turnedBev(const BevGrid& view, const Eigen::Quaterniond& R) {
  Query query;
  query.bev = view;
  return tiltedQuery(query, R).bev;
}

const Eigen::Quaterniond kTurn(Eigen::AngleAxisd(0.06, Eigen::Vector3d(1, -2, 0.5).normalized()));

BevGrid slopedSquare() {
  BevGrid view;
  view.origin_x = 640;
  view.origin_y = -128;
  view.origin_z = 40;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const float z = 0.01F * static_cast<float>(x) - 0.02F * static_cast<float>(y);
      view.known.push_back({x, y, z, (x + y) % 3 != 0});
      view[BevChannel::road].push_back(
          {0.5F * static_cast<float>(x), 0.5F * static_cast<float>(y), z});
    }
  }
  view[BevChannel::pole].push_back({3.3F, 4.1F, 0.2F});
  return view;
}

Eigen::Vector3d pointOf(const BevGrid& view, const BevSample& s) {
  return Eigen::Vector3d(view.origin_x, view.origin_y, view.origin_z) +
         Eigen::Vector3d(s.x, s.y, s.z);
}

TEST(TurnedBev, MovesEverySampleWithTheFrame) {
  const BevGrid view = slopedSquare(), turned = turnedBev(view, kTurn);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    ASSERT_EQ(turned.samples[c].size(), view.samples[c].size());
    for (std::size_t i = 0; i < view.samples[c].size(); ++i) {
      EXPECT_LT((pointOf(turned, turned.samples[c][i]) - kTurn * pointOf(view, view.samples[c][i]))
                    .norm(),
                1e-4);
    }
  }
}

TEST(TurnedBev, KnowsEachCellOnceAndInOrder) {
  const BevGrid turned = turnedBev(slopedSquare(), kTurn);
  ASSERT_FALSE(turned.known.empty());
  for (std::size_t i = 1; i < turned.known.size(); ++i) {
    const GroundCell &a = turned.known[i - 1], &b = turned.known[i];
    EXPECT_LT(std::tuple(a.y, a.x), std::tuple(b.y, b.x));
  }
}

TEST(TurnedBev, PutsCellsWhereTheirGroundIs) {
  const BevGrid view = slopedSquare(), turned = turnedBev(view, kTurn);
  for (const GroundCell& cell : turned.known) {
    const Eigen::Vector3d p(turned.origin_x + (cell.x + 0.5) * turned.cell_m,
                            turned.origin_y + (cell.y + 0.5) * turned.cell_m,
                            turned.origin_z + cell.z);
    const Eigen::Vector3d before = kTurn.conjugate() * p;
    const double x = before.x() - view.origin_x, y = before.y() - view.origin_y;
    EXPECT_NEAR(before.z() - view.origin_z, 0.02 * x - 0.04 * y, 0.08);
  }
}

TEST(TurnedBev, PrefersMeasuredHeights) {
  BevGrid view = slopedSquare();
  const BevGrid before = turnedBev(view, kTurn);
  for (GroundCell cell : slopedSquare().known) {
    cell.measured = false;
    cell.z += 5;
    view.known.insert(view.known.begin(), cell);
  }
  int measured = 0;
  for (const GroundCell& cell : turnedBev(view, kTurn).known) measured += cell.measured;
  int measured_before = 0;
  for (const GroundCell& cell : before.known) measured_before += cell.measured;
  EXPECT_GE(measured, measured_before);
}

TEST(TurnedBev, ThatIsNotTurnedIsTheSame) {
  const BevGrid view = slopedSquare(), same = turnedBev(view, Eigen::Quaterniond::Identity());
  ASSERT_EQ(same.known.size(), view.known.size());
  for (std::size_t i = 0; i < view.known.size(); ++i) {
    EXPECT_EQ(std::tuple(same.known[i].x, same.known[i].y, same.known[i].z),
              std::tuple(view.known[i].x, view.known[i].y, view.known[i].z));
    EXPECT_EQ(same.known[i].measured, view.known[i].measured);
  }
}

TEST(TurnedQuery, LeavesTheBevWhereItIs) {
  Query query;
  query.bev.alignment = Eigen::AngleAxisd(0.8, Eigen::Vector3d(2, 1, 0).normalized());
  const Query turned = turnedQuery(query, kTurn);
  const Eigen::Vector3d p(3, -4, 5);
  EXPECT_TRUE((turned.bev.alignment * (kTurn * p)).isApprox(query.bev.alignment * p));
  const Query upright = turnedQuery(query, query.bev.alignment);
  EXPECT_LT(upright.bev.alignment.angularDistance(Eigen::Quaterniond::Identity()), 1e-9);
}

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

TEST(ViewPoint, IsTheCentreOfACloudThatLiesFarAboveItsOrigin) {
  for (const double up_m : {-1000., -200., 200., 500., 1000.}) {
    Query lifted = squareAround(5, -4);
    const Eigen::Vector3d up(0, 0, up_m);
    for (Vertex& vertex : lifted.graph.vertices) vertex.position += up;
    lifted.cloud.origin += up;
    const auto centred = seenFromItsCentre(lifted);
    ASSERT_TRUE(centred) << up_m;
    EXPECT_TRUE(centred->poses[0].translation().isApprox(Eigen::Vector3d(5, -4, 3 + up_m)));
  }
}

TEST(ViewPoint, IsNotMovedByPointsFarFromTheOthers) {
  Query query = squareAround(500, -40);
  for (int i = 0; i < 20; ++i) query.cloud.points += squareAround(500, -40).cloud.points;
  query.cloud.points.push_back(Point(-200, 0, 3));  // a box around both has zero in it
  query.cloud.points.push_back(Point(-200, -100, 3));
  EXPECT_TRUE(seenFromItsCentre(query));
}

TEST(ViewPoint, IsTheMiddleWhereCoordinatesBeginInAnotherCountry) {
  const Eigen::AlignedBox3d near(Eigen::Vector3d(500, -60, 0), Eigen::Vector3d(560, 0, 10));
  EXPECT_EQ(standpoint(Eigen::Vector3d::Zero(), near), Eigen::Vector3d::Zero());
  const Eigen::Vector3d utm(691234, 5335678, 512);
  const Eigen::AlignedBox3d far(utm + near.min(), utm + near.max());
  EXPECT_TRUE(standpoint(Eigen::Vector3d::Zero(), far).isApprox(utm + near.center()));
  EXPECT_EQ(standpoint(utm, far), utm);
  EXPECT_EQ(standpoint(utm, Eigen::AlignedBox3d()), utm);
}

TEST(ViewPoint, OfADriveIsWhereItsSensorWas) {
  Query drive = squareAround(500, -40);
  drive.sensor = Sensor::camera;
  EXPECT_FALSE(seenFromItsCentre(drive));
  drive.sensor = Sensor::lidar;
  EXPECT_FALSE(seenFromItsCentre(drive));
}

TEST(WidthOfAQuery, DoesNotDependOnItsUpAndItsZero) {
  const auto roomAt = [](const Eigen::Vector3d& zero, const Eigen::Quaterniond& R_up) {
    Query query;
    query.bev.alignment = R_up;
    const Eigen::Vector3d origin = R_up * zero;
    query.bev.origin_x = origin.x();
    query.bev.origin_y = origin.y();
    query.bev.origin_z = origin.z();
    for (int i = 0; i < 20; ++i) {
      Vertex vertex;
      vertex.position = zero + R_up.conjugate() * Eigen::Vector3d(0.5 * i, 0.3 * i, 1);
      query.graph.vertices.push_back(vertex);
      query.bev.known.push_back({i, i, 0, true});
    }
    query.cloud.points.resize(600);
    return query;
  };
  map::SemanticMap map;
  static_cast<Place&>(map) = roomAt(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
  const Eigen::Quaterniond y_up(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  Query upright = roomAt({431000, 4582000, 120}, y_up);
  EXPECT_EQ(whyUnfindable(upright, map), std::nullopt);
  upright.graph.vertices[3].position += Eigen::Vector3d(900, 0, 900);
  EXPECT_EQ(whyUnfindable(upright, map), std::nullopt) << "one thing decides nothing";
  for (Vertex& vertex : upright.graph.vertices) vertex.position *= 1000;
  EXPECT_NE(whyUnfindable(upright, map).value_or("").find("m wide"), std::string::npos);
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
  const Matrix6d there = pose::movedCovariance(covariance, from, to);
  EXPECT_LT((there.topLeftCorner<3, 3>() - moved).norm(), 1e-3 * moved.norm());
  EXPECT_TRUE((there.bottomRightCorner<3, 3>()).isApprox(covariance.bottomRightCorner<3, 3>()));
}

}  // namespace
}  // namespace xview
