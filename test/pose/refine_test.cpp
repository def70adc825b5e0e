// SPDX-License-Identifier: BSD-3-Clause
#include "pose/refine.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "base/parallel.h"
#include "base/pose.h"
#include "base/random.h"
#include "support/label_sets.h"

namespace xview::pose {
namespace {

constexpr std::uint32_t kRoad = 1, kMarking = 2, kBuilding = 3, kPole = 4, kFence = 5, kCar = 6,
                        kVoid = 7;
constexpr double kDegree = M_PI / 180;

LabelSet streetLabels() {
  return test::labelSetOf("street", {{kRoad, "road", Role::surface, Kind::road},
                                     {kMarking, "lane_marking", Role::surface, Kind::lane_marking},
                                     {kBuilding, "building", Role::surface, Kind::building},
                                     {kPole, "pole", Role::object, Kind::pole},
                                     {kFence, "fence", Role::surface, Kind::fence},
                                     {kCar, "vehicle", Role::dynamic, Kind::vehicle},
                                     {kVoid, "none", Role::ignored, Kind::none}});
}

/// Points drawn at random from a few surfaces: two draws share no point.
class Street {
 public:
  explicit Street(std::uint64_t seed) : random_(seed) {}

  void add(double x, double y, double z, std::uint32_t label) {
    points_.emplace_back(Eigen::Vector3d(x, y, z), label);
  }
  void box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, std::uint32_t label,
           int count) {
    for (int i = 0; i < count; ++i) {
      add(random_.uniform(low.x(), high.x()), random_.uniform(low.y(), high.y()),
          random_.uniform(low.z(), high.z()), label);
    }
  }
  void ground(int count, std::uint32_t label = kRoad) {
    box({-20, -6, 0}, {20, 6, 0}, label, count);
  }
  void corridor(int count) {
    box({-20, 6.1, 0}, {20, 6.1, 6}, kBuilding, count);
    box({-20, -6.3, 0}, {20, -6.3, 6}, kBuilding, count);
  }
  void crossWalls(int count) {
    for (const double x : {-13.2, -4.1, 7.3, 15.4}) box({x, 6.1, 0}, {x, 9.2, 6}, kBuilding, count);
    for (const double x : {-9.3, 3.2}) box({x, -5.05, 0}, {x + 0.1, -4.95, 4}, kPole, count / 4);
  }
  void everything(int count) {
    ground(2 * count);
    corridor(count);
    crossWalls(count / 4);
  }

  const std::vector<std::pair<Eigen::Vector3d, std::uint32_t>>& points() const { return points_; }

  /// p_cloud = T * p_street, stored about `origin`.
  LabelledCloud cloud(const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity(),
                      const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) const {
    LabelledCloud result;
    result.origin = origin;
    for (const auto& [p, label] : points_) {
      Point point;
      point.getVector3fMap() = (T * p - origin).cast<float>();
      point.label = label;
      result.points.push_back(point);
    }
    return result;
  }

 private:
  Random random_;
  std::vector<std::pair<Eigen::Vector3d, std::uint32_t>> points_;
};

LabelledCloud mapCloud(const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity(),
                       const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  Street street(1);
  street.everything(20000);
  return street.cloud(T, origin);
}

DistributionMap distributions(LabelledCloud cloud,
                              const std::vector<Eigen::Isometry3d>& viewpoints = {}) {
  return DistributionMap(std::move(cloud), streetLabels(), viewpoints, {});
}

/// A cloud of which only the position of the last sensor is known.
Refinement refineAt(const DistributionMap& map, const LabelledCloud& cloud,
                    const Eigen::Isometry3d& T_map_query, const Eigen::Vector3d& sensor,
                    const RefineOptions& options = {}) {
  const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d(Eigen::Translation3d(sensor))};
  return refine(map, {cloud, poses}, streetLabels(), T_map_query, options);
}

Eigen::Isometry3d nudge(double x, double y, double z, double yaw_deg) {
  return poseFromYaw({x, y, z}, yaw_deg * kDegree);
}

TEST(Refine, RecoversASmallMotion) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  for (const Eigen::Isometry3d& error : {nudge(0.5, 0.4, 0.1, 1.5), nudge(-0.7, 0.3, -0.2, -1),
                                         nudge(0.2, -0.8, 0, 0.5), nudge(0, 0, 0, 0)}) {
    const Eigen::Isometry3d T_map_query = poseFromYaw({30, -12, 2}, 2.1);
    const Refinement refined =
        refineAt(map, street.cloud(T_map_query.inverse()), error * T_map_query,
                 T_map_query.inverse() * Eigen::Vector3d(0, 0, 1.5), {});
    ASSERT_TRUE(refined.converged);
    EXPECT_LT((refined.T_map_query.translation() - T_map_query.translation()).norm(), 0.05);
    EXPECT_LT(rotationBetween(refined.T_map_query, T_map_query), 0.1 * kDegree);
    ASSERT_TRUE(refined.agreement);
    EXPECT_GT(refined.agreement->found, 0.7);
    EXPECT_LT(refined.agreement->null_inlier_ratio, 0.5 * refined.agreement->found);
  }
}

/// Not with those of points: they make surfaces thicker, which the other half allows for.
TEST(AgreementWithItself, FallsWithTheErrorsOfLabels) {
  Street street(2);
  street.everything(6000);
  const std::vector<Eigen::Isometry3d> one{Eigen::Isometry3d::Identity()}, two(2, one[0]);
  const auto agreement = [](const LabelledCloud& cloud, const auto& poses) {
    return selfConsistency({cloud, poses}, streetLabels(), {});
  };
  LabelledCloud exact = street.cloud(), moved = exact, mistaken = exact;
  for (std::size_t i = 0; i < exact.size(); ++i)
    exact.points[i].view = moved.points[i].view = mistaken.points[i].view = (i / 7) % 2;
  Random random(3);
  for (Point& point : moved.points) {
    for (float& x : point.getVector3fMap()) x += static_cast<float>(random.uniform(-0.5, 0.5));
  }
  for (Point& point : mistaken.points) {
    if (random.below(3) == 0) point.label = kFence;
  }
  const auto best = agreement(exact, two);
  ASSERT_TRUE(best);
  EXPECT_GT(*best, 0.7);
  EXPECT_NEAR(*best, *agreement(exact, one), 0.05) << "of a single scan the points take turns";
  EXPECT_GT(*agreement(moved, two), *best);
  EXPECT_LT(*agreement(mistaken, two), *best - 0.1);
  EXPECT_FALSE(agreement(LabelledCloud(), one));
}

TEST(Refine, TheGivenPoseDecidesWhereNothingElseDoes) {
  Street map_street(1), street(2);
  map_street.box({-40, -6, 0}, {40, 6, 0}, kRoad, 80000);
  map_street.box({-40, 6.1, 0}, {40, 6.1, 6}, kBuilding, 40000);
  map_street.box({-40, -6.3, 0}, {40, -6.3, 6}, kBuilding, 40000);
  street.ground(2000);
  street.corridor(1000);
  const Refinement refined = refineAt(distributions(map_street.cloud()), street.cloud(),
                                      nudge(0.8, 0.3, 0.1, 0.5), {0, 0, 1.5});
  ASSERT_TRUE(refined.converged);
  EXPECT_NEAR(refined.T_map_query.translation().x(), 0.8, 0.25);  // along the street
  EXPECT_NEAR(refined.T_map_query.translation().y(), 0, 0.05);
}

TEST(Refine, KeepsItsPrecisionFarFromTheOrigin) {
  const Eigen::Isometry3d T_map_street = poseFromYaw({4.5e5, 5.2e6, 300}, 0.3);
  const DistributionMap map = distributions(mapCloud(T_map_street, T_map_street.translation()));
  Street street(2);
  street.everything(1500);
  const Eigen::Isometry3d T_query_street = poseFromYaw({-7e5, 1e5, 0}, -1);
  const LabelledCloud query = street.cloud(T_query_street, T_query_street.translation());
  const Eigen::Isometry3d truth = T_map_street * T_query_street.inverse();
  Eigen::Isometry3d start = truth;
  start.translation() += Eigen::Vector3d(0.4, -0.3, 0.1);
  const Eigen::Vector3d sensor = T_query_street * Eigen::Vector3d(0, 0, 1.5);
  const Refinement refined = refineAt(map, query, start, sensor, {});
  ASSERT_TRUE(refined.converged);
  EXPECT_LT((refined.T_map_query * sensor - truth * sensor).norm(), 0.05);
}

TEST(Refine, DynamicAndIgnoredClassesHaveNoSay) {
  Street map_street(1), with_cars(2);
  map_street.everything(20000);
  map_street.box({0, 1, 0.3}, {4, 3, 1.5}, kCar, 5000);
  const DistributionMap map = distributions(map_street.cloud());
  with_cars.everything(1000);
  const LabelledCloud still = with_cars.cloud();
  with_cars.box({1, 1.5, 0.3}, {5, 3.5, 1.5}, kCar, 3000);
  with_cars.box({-3, -3, 0}, {3, 3, 0.5}, kVoid, 3000);
  with_cars.box({-3, -3, 0}, {3, 3, 0.5}, 77, 3000);  // a class that is not in the set
  const Eigen::Isometry3d start = nudge(0.3, 0.2, 0, 0.5);
  const Refinement without = refineAt(map, still, start, {0, 0, 1.5}, {});
  const Refinement with = refineAt(map, with_cars.cloud(), start, {0, 0, 1.5}, {});
  ASSERT_TRUE(with.converged);
  EXPECT_EQ(with.T_map_query.matrix(), without.T_map_query.matrix());
  EXPECT_EQ(with.agreement->found, without.agreement->found);
}

TEST(Refine, LaneMarkingsLieOnTheRoadAndOtherClassesDoNotMix) {
  const DistributionMap map = distributions(mapCloud());
  Street marked(2), fenced(2);
  marked.ground(2000, kMarking);
  fenced.ground(2000, kFence);
  EXPECT_TRUE(refineAt(map, marked.cloud(), nudge(0, 0, 0.2, 0), {0, 0, 1.5}, {}).converged);
  EXPECT_FALSE(refineAt(map, fenced.cloud(), nudge(0, 0, 0.2, 0), {0, 0, 1.5}, {}).converged);
}

TEST(Refine, DoesNotConvergeWhereNothingFits) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2), few(3), cars(4);
  street.everything(1000);
  few.ground(40);
  cars.box({0, 0, 0}, {4, 2, 1}, kCar, 2000);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_FALSE(refineAt(map, street.cloud(), nudge(100, 0, 0, 0), {0, 0, 1.5}, {}).converged);
  EXPECT_FALSE(refineAt(map, few.cloud(), here, {0, 0, 1.5}, {}).converged);
  EXPECT_FALSE(refineAt(map, cars.cloud(), here, {0, 0, 1.5}, {}).converged);
  EXPECT_FALSE(refineAt(map, LabelledCloud(), here, {0, 0, 1.5}, {}).converged);
  const DistributionMap nothing = distributions(LabelledCloud());
  EXPECT_EQ(nothing.size(), 0u);
  EXPECT_FALSE(refineAt(nothing, street.cloud(), here, {0, 0, 1.5}, {}).converged);
}

TEST(Refine, GivesUpIfThePoseMovesTooFar) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  RefineOptions options;
  options.max_shift_m = 0.3;
  EXPECT_FALSE(refineAt(map, street.cloud(), nudge(0, 0.8, 0, 0), {0, 0, 1.5}, options).converged);
  EXPECT_TRUE(refineAt(map, street.cloud(), nudge(0, 0.2, 0, 0), {0, 0, 1.5}, options).converged);
}

/// The plan of a room may have taken a table for its ground.
TEST(Refine, RisesToTheRightHeightBeforeItIsAskedHowFarThePoseMoves) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  RefineOptions options;
  options.max_shift_m = 1;
  for (const double up_m : {-2.5, -1.6, 1.6, 2.5}) {
    const Refinement found =
        refineAt(map, street.cloud(), nudge(0.3, -0.2, up_m, 0), {0, 0, 1.5}, options);
    ASSERT_TRUE(found.converged) << up_m;
    EXPECT_LT(found.T_map_query.translation().norm(), 0.05) << up_m;
  }
}

/// From above walls are seen higher up than from a street, which lies on its ground nevertheless.
TEST(Refine, StaysOnItsGroundWhereTheMapHasMoreOfTheUpperPartsOfWalls) {
  const auto addWalls = [](double low, double high, int count, Street& street) {
    for (const double y : {6.1, -6.3}) street.box({-20, y, low}, {20, y, high}, kBuilding, count);
    for (const double x : {-13.2, -4.1, 7.3, 15.4})
      street.box({x, 6.1, low}, {x, 9.2, high}, kBuilding, count / 8);
  };
  Street above(1), below(2);
  above.ground(20000);
  addWalls(0, 2.6, 800, above);
  addWalls(2.6, 8, 20000, above);
  below.ground(1000);
  addWalls(0.2, 4, 3000, below);
  const DistributionMap map = distributions(above.cloud());
  for (const double up_m : {-0.3, 0.0, 0.3}) {
    const Refinement found = refineAt(map, below.cloud(), nudge(0.2, 0.1, up_m, 0), {0, 0, 1.5});
    ASSERT_TRUE(found.converged) << up_m;
    EXPECT_LT(found.T_map_query.translation().norm(), 0.1) << up_m;
  }
}

TEST(Refine, TrustsGravityAsMuchAsItIsTold) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.linear() = Eigen::AngleAxisd(0.6 * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto tilt = [&](double sigma_deg) {
    RefineOptions options;
    options.tilt_sigma_deg = sigma_deg;
    const Refinement r = refineAt(map, street.cloud(), start, {0, 0, 1.5}, options);
    EXPECT_TRUE(r.converged);
    return std::acos(std::min(1.0, r.T_map_query.linear()(2, 2))) / kDegree;
  };
  EXPECT_LT(tilt(10), 0.1) << "the walls say that the start was tilted";
  EXPECT_GT(tilt(0.002), 0.5) << "gravity says that the start was upright";
}

TEST(Refine, CovarianceIsLargestAlongACorridor) {
  Street map_street(1), street(2);
  map_street.ground(40000);
  map_street.corridor(20000);
  street.ground(2000);
  street.corridor(2000);
  const Refinement r = refineAt(distributions(map_street.cloud()), street.cloud(),
                                nudge(0, 0.1, 0, 0), {0, 0, 1.5}, {});
  ASSERT_TRUE(r.converged);
  EXPECT_LT((r.covariance - r.covariance.transpose()).norm(), 1e-9);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(r.covariance).eigenvalues().minCoeff(), 0);
  EXPECT_GT(r.covariance(0, 0), r.covariance(1, 1));
}

TEST(Refine, PointsThatAreNoNumbersAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  LabelledCloud map_cloud = mapCloud();
  Street street(2);
  street.everything(1000);
  LabelledCloud query = street.cloud();
  const Refinement clean =
      refineAt(distributions(map_cloud), query, nudge(0.2, 0.1, 0, 0), {0, 0, 1.5}, {});
  for (LabelledCloud* cloud : {&map_cloud, &query}) {
    for (int i = 0; i < 20; ++i) cloud->points.push_back(Point(nan, 0, 0, kRoad));
  }
  const Refinement dirty =
      refineAt(distributions(map_cloud), query, nudge(0.2, 0.1, 0, 0), {0, 0, 1.5}, {});
  ASSERT_TRUE(dirty.converged);
  EXPECT_EQ(dirty.T_map_query.matrix(), clean.T_map_query.matrix());
}

TEST(Refine, FewerPointsOfTheQueryAreUsedAsTold) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(3000);
  RefineOptions options;
  options.model.max_points = 300;
  const Refinement r = refineAt(map, street.cloud(), nudge(0.3, 0.2, 0, 0.3), {0, 0, 1.5}, options);
  ASSERT_TRUE(r.converged);
  EXPECT_LT(r.T_map_query.translation().norm(), 0.15);
  options.model.max_points = 40;  // fewer than any fit needs
  EXPECT_FALSE(
      refineAt(map, street.cloud(), nudge(0.3, 0.2, 0, 0.3), {0, 0, 1.5}, options).converged);
}

/// A drive along x that ends in the origin, each point seen from the pose it is nearest to, with an
/// odometry whose ways are `scale` times as long.
struct Drive {
  LabelledCloud cloud;
  std::vector<Eigen::Isometry3d> poses;

  Drive(const Street& street, double scale) {
    for (double x = -20; x <= 0; x += 2)
      poses.emplace_back(Eigen::Translation3d(scale * x, 0, 1.5));
    for (const auto& [p, label] : street.points()) {
      const auto i =
          static_cast<std::uint32_t>(std::clamp(std::round((p.x() + 20) / 2), 0.0, 10.0));
      Point point;
      point.getVector3fMap() =
          (p + Eigen::Vector3d((scale - 1) * (2.0 * i - 20), 0, 0)).cast<float>();
      point.label = label;
      point.view = i;
      cloud.points.push_back(point);
    }
  }
  Refinement refined(const DistributionMap& map, const RefineOptions& options) const {
    return refine(map, {cloud, poses}, streetLabels(), nudge(0.2, 0.1, 0, 0.2), options);
  }
};

double errorOfLast(const Refinement& r) {
  return (r.T_map_query * Eigen::Vector3d(0, 0, 1.5) - Eigen::Vector3d(0, 0, 1.5)).norm();
}

TEST(Refine, TakesUpTheDriftOfTheOdometry) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(2000);
  RefineOptions rigid;
  rigid.model.drift_share = 0;
  for (const double scale : {0.97, 1.03}) {
    const Drive drive(street, scale);
    const Refinement with = drive.refined(map, {}), without = drive.refined(map, rigid);
    ASSERT_TRUE(with.converged && without.converged);
    EXPECT_LT(errorOfLast(with), 0.1);
    EXPECT_LT(errorOfLast(with), 0.5 * errorOfLast(without));
    ASSERT_EQ(with.T_map_query_at.size(), drive.poses.size());
    EXPECT_EQ(with.T_map_query_at.back().matrix(), with.T_map_query.matrix());
    const Eigen::Vector3d first = drive.poses.front().translation();
    EXPECT_LT((with.T_map_query_at.front() * first - Eigen::Vector3d(-20, 0, 1.5)).norm(), 0.2)
        << "0.6 m off by the pose of the last";
  }
}

TEST(Refine, LosesLittleWithoutDrift) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(2000);
  const Refinement r = Drive(street, 1).refined(map, {});
  ASSERT_TRUE(r.converged);
  EXPECT_LT(errorOfLast(r), 0.05);
}

TEST(Refine, CovarianceKnowsPosesThatRollEachOnItsOwn) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(2000);
  Drive steady(street, 1), rolling(street, 1);
  constexpr double kRoll = 0.006;
  for (std::size_t i = 0; i < rolling.cloud.size(); ++i) {
    const std::uint32_t pose = rolling.cloud.points[i].view;
    const Eigen::AngleAxisd roll(pose % 2 == 0 ? kRoll : -kRoll, Eigen::Vector3d::UnitX());
    const Eigen::Vector3d at = rolling.poses[pose].translation();
    rolling.cloud.points[i].getVector3fMap() =
        (at + roll * (rolling.cloud.position(i) - at)).cast<float>();
  }
  const auto sigma = [&](const Drive& drive) {
    const Refinement r = drive.refined(map, {});
    EXPECT_TRUE(r.converged);
    return std::sqrt(r.covariance(3, 3));
  };
  EXPECT_LT(sigma(steady), 0.001);
  EXPECT_GT(sigma(rolling), 3 * sigma(steady));
  EXPECT_LT(sigma(rolling), 2 * kRoll);
}

TEST(Refine, FindsTheWayAlongAStreetThatSaysLittleAboutIt) {
  Street map_street(1), street(2);
  map_street.ground(40000);
  map_street.corridor(20000);
  map_street.crossWalls(4000);
  street.ground(3000);
  street.corridor(3000);
  street.crossWalls(100);
  const DistributionMap map = distributions(map_street.cloud());
  for (const double off : {-1.1, 1.1}) {
    const Refinement r = refineAt(map, street.cloud(), nudge(off, 0.1, 0, 0.3), {0, 0, 1.5});
    ASSERT_TRUE(r.converged);
    EXPECT_LT(r.T_map_query.translation().norm(), 0.1) << off;
  }
}

TEST(Refine, TheOtherSideOfAThingCountsLittle) {
  // Fences across the way, a decimetre thick. The map was made looking along x; so were the walls
  // of the query, but its fences were seen looking back.
  const auto streetWithFences = [](int seed, int count, double side) {
    Street street(seed);
    street.everything(count);
    for (double x = -18; x < 20; x += 9)
      street.box({x + side, 3, 0}, {x + side + 0.05, 5.5, 2}, kFence, count / 10);
    return street.cloud();
  };
  Eigen::Isometry3d looks_ahead = Eigen::Isometry3d::Identity();
  looks_ahead.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  std::vector<Eigen::Isometry3d> viewpoints;
  for (double x = -30; x <= 20; x += 2) {
    looks_ahead.translation() = Eigen::Vector3d(x, 0, 1.5);
    viewpoints.push_back(looks_ahead);
  }
  const LabelledCloud map_cloud = streetWithFences(1, 15000, 0);
  LabelledCloud query = streetWithFences(2, 1500, 0.1);
  const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d(Eigen::Translation3d(-25, 0, 1.5)),
                                             Eigen::Isometry3d(Eigen::Translation3d(25, 0, 1.5))};
  for (Point& point : query.points) point.view = point.label == kFence ? 1 : 0;
  RefineOptions options;
  options.model.drift_share = 0;
  const auto error = [&](const DistributionMap& map) {
    const Refinement r = refine(map, {query, poses}, streetLabels(), nudge(0, 0, 0, 0), options);
    EXPECT_TRUE(r.converged);
    return std::abs(r.T_map_query.translation().x());
  };
  EXPECT_LT(error(distributions(map_cloud, viewpoints)), 0.5 * error(distributions(map_cloud)));
}

TEST(Refine, CovarianceGrowsWithTheErrorOfTheSensor) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  LabelledCloud cloud = street.cloud();
  const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d(Eigen::Translation3d(0, 0, 1.5))};
  const auto sigma = [&](float sensor_m) {
    for (Point& point : cloud.points) point.sigma = sensor_m;
    const Refinement r = refine(map, {cloud, poses}, streetLabels(), nudge(0.1, 0, 0, 0), {});
    return std::sqrt(r.covariance(0, 0));
  };
  EXPECT_LT(sigma(0), 0.1);
  EXPECT_GT(sigma(0.3f), 3 * sigma(0));
  EXPECT_GT(sigma(0.3f), 0.008);
}

TEST(DistributionMap, HasOneDistributionPerCellAndGroup) {
  LabelledCloud cloud;
  for (const std::uint32_t label : {kRoad, kMarking, kBuilding, kCar, kVoid}) {
    for (int i = 0; i < 10; ++i) cloud.points.push_back(Point(0.1f, 0.1f, 0.1f, label));
    cloud.points.push_back(Point(-0.1f, 0.1f, 0.1f, label));
  }
  EXPECT_EQ(distributions(cloud).size(), 4u)
      << "road with its markings, and the building, in two cells each";
}

/// Pieces of the street far from one another, each found from 1 m away.
std::vector<Refinement> refinedAlong(const DistributionMap& map, const std::vector<double>& at_m,
                                     int threads) {
  Street street(2);
  street.everything(1500);
  std::vector<Refinement> found(at_m.size());
  parallelFor(at_m.size(), threads, [&](std::size_t i) {
    const Eigen::Isometry3d T = Eigen::Translation3d(at_m[i], 0, 0) * nudge(0.5, 0.3, 0.1, 0.5);
    found[i] = refineAt(map, street.cloud(), T, {0, 0, 1.5});
  });
  return found;
}

/// Several streets end to end.
LabelledCloud longMap(const std::vector<double>& at_m) {
  LabelledCloud all;
  for (const double x : at_m) {
    for (Point p : mapCloud().points) {
      p.x += static_cast<float>(x);
      all.points.push_back(p);
    }
  }
  return all;
}

TEST(DistributionMap, AnswersDoNotDependOnEarlierQuestionsNorOnThreads) {
  const std::vector<double> at_m{0, 400, -800, 1200};
  const DistributionMap asked_before = distributions(longMap(at_m)),
                        shared = distributions(longMap(at_m));
  EXPECT_GT(asked_before.size(), 0u);
  const std::vector<Refinement> expected = refinedAlong(asked_before, at_m, 1);
  const std::vector<Refinement> by_threads =
      refinedAlong(shared, {0, 400, -800, 1200, 0, 400, -800, 1200}, 4);
  for (std::size_t i = 0; i < by_threads.size(); ++i) {
    const Refinement& e = expected[i % at_m.size()];
    EXPECT_TRUE(e.converged);
    EXPECT_EQ(by_threads[i].T_map_query.matrix(), e.T_map_query.matrix());
    EXPECT_EQ(by_threads[i].covariance, e.covariance);
  }
  for (std::size_t i = 0; i < at_m.size(); ++i) {
    const DistributionMap fresh = distributions(longMap(at_m));
    EXPECT_EQ(refinedAlong(fresh, {at_m[i]}, 1)[0].T_map_query.matrix(),
              expected[i].T_map_query.matrix());
  }
}

TEST(Refine, CovarianceOfABentScanIsWide) {
  const DistributionMap map = distributions(mapCloud());
  Street street(2);
  street.everything(1500);
  const auto sigma = [&](float bend_m) {
    LabelledCloud cloud = street.cloud();
    for (Point& p : cloud.points) p.y += bend_m * std::sin(p.x / 4);
    const Refinement r = refineAt(map, cloud, nudge(0, 0, 0, 0), {0, 0, 1.5});
    EXPECT_TRUE(r.converged);
    return std::sqrt(r.covariance(1, 1));
  };
  EXPECT_LT(sigma(0), 0.01);
  EXPECT_GT(sigma(0.3F), 0.17) << "much more than its points spread";
}

TEST(Refine, AStreetThatTellsNothingLengthwiseLeavesThePlaceAlongItOpen) {
  Street map_street(1), query_street(2);
  map_street.ground(40000);
  map_street.corridor(20000);
  query_street.box({-8, -6, 0}, {8, 6, 0}, kRoad, 8000);
  for (const double y : {6.1, -6.3}) query_street.box({-8, y, 0}, {8, y, 6}, kBuilding, 4000);
  const DistributionMap map = distributions(map_street.cloud());
  const LabelledCloud cloud = query_street.cloud();
  for (const double off : {-0.6, -0.3, 0.3, 0.6}) {
    const Refinement found =
        refineAt(map, cloud, poseFromYaw({off, 0, 0}, 0), Eigen::Vector3d(0, 0, 1.5));
    ASSERT_TRUE(found.converged) << off;
    const double error = found.T_map_query.translation().x();
    EXPECT_LT(std::abs(error), 4 * std::sqrt(found.covariance(0, 0))) << off << " " << error;
    EXPECT_LT(found.covariance(1, 1), 0.02 * 0.02) << "across it is known";
  }
}

/// One point per voxel of 0.8 m, as in thinned maps of sparse scanners: no cell makes a
/// distribution of its own points.
TEST(Refine, FindsHeightAndTiltInASparseMap) {
  LabelledCloud dense = mapCloud(), sparse = dense;
  sparse.points.clear();
  std::set<std::array<int, 4>> taken;
  for (const Point& p : dense.points) {
    const auto cell = [](float c) { return static_cast<int>(std::floor(c / 0.8F)); };
    if (taken.insert({cell(p.x), cell(p.y), cell(p.z), static_cast<int>(p.label)}).second)
      sparse.points.push_back(p);
  }
  ASSERT_LT(sparse.size(), 4000u);
  const DistributionMap map = distributions(std::move(sparse));
  Street street(2);
  street.everything(1500);
  RefineOptions options;
  options.tilt_sigma_deg = 3;
  Eigen::Isometry3d error = nudge(0.3, -0.2, -0.5, 1);
  error.rotate(Eigen::AngleAxisd(2 * kDegree, Eigen::Vector3d::UnitY()));
  const Refinement found = refineAt(map, street.cloud(), error, Eigen::Vector3d::Zero(), options);
  ASSERT_TRUE(found.converged);
  EXPECT_LT(found.T_map_query.translation().norm(), 0.1);
  EXPECT_LT(rotationBetween(found.T_map_query, Eigen::Isometry3d::Identity()), 0.5 * kDegree);
}

}  // namespace
}  // namespace xview::pose
