// SPDX-License-Identifier: BSD-3-Clause
#include "base/stray_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// A place of 100 x 60 x 10 m around a point.
std::vector<Eigen::Vector3d> placeAround(const Eigen::Vector3d& middle, std::size_t points) {
  Random random(1);
  std::vector<Eigen::Vector3d> place;
  for (std::size_t i = 0; i < points; ++i) {
    const double x = random.uniform(-50, 50), y = random.uniform(-30, 30);
    place.emplace_back(middle + Eigen::Vector3d(x, y, random.uniform(0, 10)));
  }
  return place;
}

LabelledCloud built(const std::vector<Eigen::Vector3d>& positions, double far_m) {
  CloudBuilder builder(far_m);
  for (const Eigen::Vector3d& p : positions) builder.add(p, Point());
  return builder.finish("cloud");
}

LabelledCloud inFloats(const std::vector<Eigen::Vector3d>& positions) {
  LabelledCloud cloud;
  for (const Eigen::Vector3d& p : positions) {
    cloud.points.push_back(Point());
    cloud.points.back().getVector3fMap() = p.cast<float>();
  }
  leaveOutStrays("cloud", cloud);
  return cloud;
}

/// Points that come behind a stray lose less than a millimetre beside it.
void expectSame(const LabelledCloud& cloud, const LabelledCloud& expected) {
  EXPECT_EQ(cloud.origin, expected.origin);
  ASSERT_EQ(cloud.size(), expected.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ASSERT_LT((cloud.position(i) - expected.position(i)).norm(), 1e-3) << i;
}

const Eigen::Vector3d kUtm(431000.25, 4582000.5, 120);

TEST(StrayPoints, LeaveTheCloudAsWithoutThemWhereverTheyStand) {
  for (const Eigen::Vector3d& middle : {Eigen::Vector3d(3, 4, 5), kUtm}) {
    const auto place = placeAround(middle, 2000);
    const LabelledCloud expected = built(place, 1000);
    EXPECT_FALSE(expected.left_out.any());
    for (const double away : {5e3, 1e6, 1e9, 1e12, 1e30, 1e300}) {
      for (const std::size_t at : {0, 1000, 2000}) {
        for (const std::size_t strays : {1, 40, 150}) {
          auto with = place;
          for (std::size_t i = 0; i < strays; ++i)
            with.insert(
                with.begin() + static_cast<std::ptrdiff_t>(at),
                middle + away * (1 + 0.001 * static_cast<double>(i)) * Eigen::Vector3d(1, -1, 0.5));
          const LabelledCloud cloud = built(with, 1000);
          expectSame(cloud, expected);
          EXPECT_EQ(cloud.left_out.far, strays) << away;
          EXPECT_EQ(cloud.left_out.of, with.size());
        }
      }
    }
  }
}

TEST(StrayPoints, OfFloatsAreLeftOutWithWhatIsNoNumber) {
  const auto place = placeAround({0, 0, 0}, 3000);
  const LabelledCloud expected = inFloats(place);
  auto with = place;
  with[17] = {1e10, 0, 0};
  with.insert(with.begin(), {-3e38, 3e38, 0});
  with.insert(with.begin() + 9, {0, std::nan(""), 0});
  const LabelledCloud cloud = inFloats(with);
  EXPECT_EQ(cloud.size(), expected.size() - 1);
  EXPECT_EQ(cloud.left_out.far, 2u);
  EXPECT_EQ(
      cloud.left_out.text(),
      "2 of 3002 points lie more than 1.6 km from the middle of the others, and are left out");
}

TEST(StrayPoints, ThatRepeatOnePositionAreLeftOutIfTheyAreMany) {
  for (const double share : {0.02, 0.3, 0.6, 0.9}) {
    const auto place = placeAround(kUtm, 5000);
    const auto zeros = static_cast<std::size_t>(share / (1 - share) * 5000);
    auto with = place;
    with.insert(with.begin(), zeros, Eigen::Vector3d::Zero());
    const LabelledCloud cloud = built(with, 1000);
    expectSame(cloud, built(place, 1000));
    EXPECT_EQ(cloud.left_out.repeated, zeros);
  }
}

TEST(StrayPoints, AreNoneWhereAllIsOnePlace) {
  auto twice = placeAround(kUtm, 2000);
  twice.insert(twice.end(), twice.begin(), twice.begin() + 1000);
  EXPECT_EQ(built(twice, 1000).size(), 3000u);
  EXPECT_EQ(built(std::vector<Eigen::Vector3d>(500, kUtm), 1000).size(), 500u);
  EXPECT_TRUE(built({}, 1000).empty());
  auto towns = placeAround({0, 0, 0}, 2000);  // two of them, 20 km apart
  const auto other = placeAround({20000, 0, 0}, 1000);
  towns.insert(towns.end(), other.begin(), other.end());
  EXPECT_EQ(inFloats(towns).size(), 3000u);
  auto millimetres = placeAround({0, 0, 0}, 2000);  // of a town of 10 x 6 km
  for (Eigen::Vector3d& p : millimetres) p *= 1e5;
  EXPECT_EQ(inFloats(millimetres).size(), 2000u);
}

TEST(StrayPoints, ThatAreTheMostAreAnError) {
  Random random(2);
  std::vector<Eigen::Vector3d> anywhere;
  for (int i = 0; i < 1000; ++i)
    anywhere.emplace_back(std::pow(10, random.uniform(8, 30)), random.uniform(-1e9, 1e9), 0);
  EXPECT_THROW(built(anywhere, 1000), Error);
  EXPECT_THROW(inFloats(anywhere), Error);
  EXPECT_THROW(inFloats(std::vector<Eigen::Vector3d>(10, {1e12, 1e12, 1e12})), Error);
}

TEST(StrayPoints, DoNotWidenABox) {
  auto place = placeAround(kUtm, 5000);
  const auto boxOf = [&] {
    return boxWithoutStrays(place.size(), [&](std::size_t i) { return place[i]; });
  };
  const Eigen::AlignedBox3d expected = boxOf();
  EXPECT_NEAR(expected.sizes().x(), 100, 0.1);
  for (int i = 0; i < 200; ++i) place.push_back(kUtm + Eigen::Vector3d(900 + i, -400, 300));
  EXPECT_TRUE(boxOf().isApprox(expected, 0));
  EXPECT_TRUE(boxWithoutStrays(0, {}).isEmpty());
}

}  // namespace
}  // namespace xview
