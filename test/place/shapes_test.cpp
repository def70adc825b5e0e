// SPDX-License-Identifier: BSD-3-Clause
#include "place/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "xview/io/label_files.h"

namespace xview {
namespace {

/// A street as points of known shapes: `label` holds the true one.
class Street {
 public:
  Street() : random_(7) {
    plane({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, Shape::ground, 40000);
    plane({-20, 12, 0.5F}, {40, 0, 0}, {0, 0, 6}, Shape::wall, 20000);
    for (const float x : {-9.F, 3.F, 12.F}) column({x, 6, 0.5F}, 0.08F, 4.5F, Shape::post, 500);
    crown({-6, -8, 4}, 2, Shape::foliage, 4000);
    plane({4, -6, 0.4F}, {4, 0, 0}, {0, 0, 1.1F}, Shape::low_thing, 1500);
    plane({4, -6, 1.5F}, {4, 0, 0}, {0, 1.8F, 0}, Shape::low_thing, 1500);
  }

  const pcl::PointCloud<Point>& points() const { return points_; }
  /// Share of the points of a shape that are given it.
  static double recall(const pcl::PointCloud<Point>& truth, const pcl::PointCloud<Point>& found,
                       Shape shape) {
    double all = 0, right = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (truth[i].label != static_cast<std::uint32_t>(shape)) continue;
      all += 1;
      right += found[i].label == truth[i].label;
    }
    return right / all;
  }

 private:
  float draw(float from, float to) {
    return from + (to - from) * static_cast<float>(random_.uniform());
  }
  void add(const Eigen::Vector3f& p, Shape shape) {
    points_.push_back({p.x(), p.y(), p.z(), static_cast<std::uint32_t>(shape)});
  }
  void plane(const Eigen::Vector3f& corner, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
             Shape shape, int count) {
    for (int i = 0; i < count; ++i) {
      const float u = draw(0, 1), v = draw(0, 1);
      add(corner + u * a + v * b + Eigen::Vector3f(draw(-0.01F, 0.01F), 0, draw(-0.01F, 0.01F)),
          shape);
    }
  }
  void column(const Eigen::Vector3f& foot, float radius, float height, Shape shape, int count) {
    for (int i = 0; i < count; ++i) {
      const float angle = draw(0, 6.28F);
      add(foot +
              Eigen::Vector3f(radius * std::cos(angle), radius * std::sin(angle), draw(0, height)),
          shape);
    }
  }
  void crown(const Eigen::Vector3f& middle, float radius, Shape shape, int count) {
    while (count > 0) {
      const Eigen::Vector3f p(draw(-radius, radius), draw(-radius, radius), draw(-radius, radius));
      if (p.norm() > radius) continue;
      add(middle + p, shape);
      --count;
    }
  }

  Random random_;
  pcl::PointCloud<Point> points_;
};

/// What stands, as a stereo camera far away sees it.
pcl::PointCloud<Point> scattered(pcl::PointCloud<Point> points, float sigma_m) {
  Random random(11);
  for (Point& p : points) {
    if (p.label == static_cast<std::uint32_t>(Shape::ground)) continue;
    p.x += sigma_m * static_cast<float>(random.normal());
    p.y += sigma_m * static_cast<float>(random.normal());
  }
  return points;
}

TEST(Shapes, WallsAreToldWherePointsErrByMoreThanWhatIsLookedAt) {
  const pcl::PointCloud<Point> truth = scattered(Street().points(), 0.6F);
  pcl::PointCloud<Point> found = truth;
  labelByShape(found);
  EXPECT_GT(Street::recall(truth, found, Shape::wall), 0.5);
  EXPECT_GT(Street::recall(truth, found, Shape::foliage), 0.9);

  // Who says how far points err has smoothed what is smooth.
  found = truth;
  for (Point& p : found) p.sigma = 0.6F;
  labelByShape(found);
  EXPECT_LT(Street::recall(truth, found, Shape::wall), 0.3);
}

TEST(Shapes, OfAStreetAreTold) {
  const Street street;
  pcl::PointCloud<Point> found = street.points();
  labelByShape(found);
  EXPECT_GT(Street::recall(street.points(), found, Shape::ground), 0.99);
  EXPECT_GT(Street::recall(street.points(), found, Shape::wall), 0.95);
  EXPECT_GT(Street::recall(street.points(), found, Shape::post), 0.8);
  EXPECT_GT(Street::recall(street.points(), found, Shape::foliage), 0.6);
  EXPECT_GT(Street::recall(street.points(), found, Shape::low_thing), 0.9);
}

/// Nothing says where the sensor was: cells lie elsewhere then, and what is beside their borders
/// may change.
TEST(Shapes, HardlyDependOnWhereTheOriginIs) {
  const Street street;
  pcl::PointCloud<Point> here = street.points(), there = street.points();
  for (Point& p : there) p.getVector3fMap() += Eigen::Vector3f(500.3F, -211.7F, 38.4F);
  labelByShape(here);
  labelByShape(there);
  double same = 0;
  for (std::size_t i = 0; i < here.size(); ++i) same += here[i].label == there[i].label;
  EXPECT_GT(same / static_cast<double>(here.size()), 0.95);
}

/// A facade far from a scanner whose columns are a metre apart there.
TEST(Shapes, OfAScanColumnOverASurfaceAreNoPosts) {
  pcl::PointCloud<Point> points;
  Random random(5);
  for (int i = 0; i < 20000; ++i)
    points.push_back({static_cast<float>(random.uniform(-20, 20)),
                      static_cast<float>(random.uniform(-20, 9)), 0});
  const std::size_t ground = points.size();
  for (int column = -15; column <= 15; ++column) {
    for (int i = 0; i < 50; ++i)
      points.push_back({static_cast<float>(column), 10, 0.5F + 0.1F * static_cast<float>(i)});
  }
  labelByShape(points);
  std::size_t posts = 0;
  for (std::size_t i = ground; i < points.size(); ++i)
    posts += points[i].label == static_cast<std::uint32_t>(Shape::post);
  EXPECT_LT(posts, (points.size() - ground) / 20);
}

TEST(Shapes, OfASlopeAreGround) {
  pcl::PointCloud<Point> slope;
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const auto x = static_cast<float>(60 * random.uniform());
    slope.push_back({x, static_cast<float>(30 * random.uniform()), 0.1F * x});
  }
  labelByShape(slope);
  std::size_t ground = 0;
  for (const Point& p : slope) ground += p.label == static_cast<std::uint32_t>(Shape::ground);
  EXPECT_GT(ground, slope.size() * 99 / 100);
}

/// Check fix for: all furniture of a room was a low thing, which is left out as vehicles are, and
/// what has the size of voxels of a town was scattered.
TEST(Shapes, OfARoomAreThoseOfAStreetInSmall) {
  const Street street;
  const float small = static_cast<float>(kRoomScale);
  pcl::PointCloud<Point> room = street.points();
  for (Point& p : room) p.getVector3fMap() *= small;
  labelByShape(room, kRoomScale);
  EXPECT_EQ(Street::recall(street.points(), room, Shape::low_thing), 0);
  const double walls = Street::recall(street.points(), room, Shape::wall);
  EXPECT_GT(walls, 0.9);
  pcl::PointCloud<Point> as_large = street.points();
  labelByShape(as_large, kRoomScale);
  EXPECT_EQ(Street::recall(street.points(), as_large, Shape::low_thing), 0) << "as large as a car";
}

/// Check fix for: walls of which a scanner sees no more than the foot were vehicles.
TEST(Shapes, WallsAsLowAsVehiclesAreLonger) {
  const Street street;
  pcl::PointCloud<Point> low = street.points();
  for (Point& p : low) p.getVector3fMap() *= static_cast<float>(kRoomScale);
  labelByShape(low, kTownScale);
  EXPECT_GT(Street::recall(street.points(), low, Shape::wall), 0.85);
}

TEST(Shapes, OfNothingOrOnePointAreNoError) {
  pcl::PointCloud<Point> cloud;
  labelByShape(cloud);
  EXPECT_TRUE(cloud.empty());
  cloud.push_back({1, 2, 3});
  labelByShape(cloud);
  EXPECT_EQ(cloud[0].label, static_cast<std::uint32_t>(Shape::ground));
}

TEST(Shapes, HaveTheIdsOfTheirLabelSet) {
  const LabelSet set = io::shippedLabelSet("shapes");
  EXPECT_EQ(set, labelsOfShapes());
  EXPECT_EQ(set.classes().size(), kShapeCount);
  EXPECT_EQ(set.className(static_cast<std::uint32_t>(Shape::ground)), "ground");
  EXPECT_EQ(set.className(static_cast<std::uint32_t>(Shape::low_thing)), "low thing");
  EXPECT_EQ(set.className(static_cast<std::uint32_t>(Shape::table)), "table");
  EXPECT_EQ(set.kind(static_cast<std::uint32_t>(Shape::wall)), Kind::building);
}

}  // namespace
}  // namespace xview
