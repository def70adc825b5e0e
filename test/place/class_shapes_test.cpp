// SPDX-License-Identifier: BSD-3-Clause
#include "place/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "base/random.h"

namespace xview {
namespace {

enum : std::uint32_t { kStreet = 11, kLawn, kHouse, kPost, kCar, kHedge, kRare };

/// A street of 60 m with a lawn, house fronts, posts, cars and a hedge on a slope, 0.1 m between
/// points, before `unevenness_m` of noise.
class Street {
 public:
  explicit Street(double slope, double noise_m = 0) : slope_(slope), noise_m_(noise_m) {
    box(kStreet, 0, 60, -3, 3, 0, 0);
    box(kLawn, 0, 60, 3, 12, 0, 0);
    box(kHouse, 0, 50, 12, 12.2, 0, 6);
    box(kHedge, 0, 60, -4, -3.4, 0, 1.2);
    for (const double x : {5., 20., 40., 55.}) {
      box(kPost, x, x + 0.2, 3.2, 3.4, 0, 4);
      box(kCar, x + 5, x + 9, 1, 2.7, 0.3, 1.5);
    }
    box(kRare, 30, 30.1, 8, 8.1, 0, 0.1);
  }

  LabelledCloud cloud;

 private:
  void box(std::uint32_t label, double x0, double x1, double y0, double y1, double z0, double z1) {
    constexpr double kStep_m = 0.1;
    for (double x = x0; x <= x1; x += kStep_m) {
      for (double y = y0; y <= y1; y += kStep_m) {
        for (double z = z0; z <= z1; z += kStep_m) {
          Point point;
          point.x = static_cast<float>(x);
          point.y = static_cast<float>(y);
          point.z = static_cast<float>(z + slope_ * x + noise_m_ * random_.normal());
          point.label = label;
          cloud.points.push_back(point);
        }
      }
    }
  }

  double slope_, noise_m_;
  Random random_{4};
};

const LabelSet kUnnamed =
    genericLabelSet({0, kStreet, kLawn, kHouse, kPost, kCar, kHedge, kRare, 99});

void expectStreet(const LabelSet& found) {
  EXPECT_EQ(found.kind(kLawn), Kind::road);  // the largest ground, whatever it is
  EXPECT_EQ(found.kind(kStreet), Kind::terrain);
  EXPECT_EQ(found.role(kStreet), Role::surface);
  EXPECT_EQ(found.kind(kHouse), Kind::building);
  EXPECT_EQ(found.role(kHouse), Role::surface);
  EXPECT_EQ(found.kind(kHedge), Kind::fence);
  EXPECT_EQ(found.kind(kPost), Kind::pole);
  EXPECT_EQ(found.role(kPost), Role::object);
  EXPECT_EQ(found.kind(kCar), Kind::vehicle);
  EXPECT_EQ(found.role(kCar), Role::dynamic);
}

TEST(ClassShapes, AStreetIsToldApartOnTheLevelAndOnASlope) {
  for (const double slope : {0.0, 0.12}) {
    SCOPED_TRACE(slope);
    expectStreet(rolesByShape(kUnnamed, Street(slope).cloud));
  }
}

TEST(ClassShapes, NoiseAndAnOriginFarAwayChangeNothing) {
  Street street(0.05, 0.05);
  street.cloud.origin = {500000, 4649776, 250};
  expectStreet(rolesByShape(kUnnamed, street.cloud));
}

TEST(ClassShapes, WhatIsTooSmallOrAbsentStaysAnObject) {
  const LabelSet found = rolesByShape(kUnnamed, Street(0).cloud);
  for (const std::uint32_t id : {std::uint32_t{kRare}, 99U}) {
    EXPECT_EQ(found.role(id), Role::object);
    EXPECT_EQ(found.kind(id), Kind::other_object);
  }
  EXPECT_EQ(found.role(0), Role::ignored);
  EXPECT_TRUE(found.isGeneric());
}

/// The street with names that say nothing, but for one; a tenth of its points, in patches, has
/// another class.
struct NamedStreet {
  LabelSet labels{"odd"};
  LabelledCloud cloud = Street(0.05).cloud;

  NamedStreet() {
    const std::pair<std::uint32_t, const char*> classes[] = {{kStreet, "zorb"}, {kLawn, "blip"},
                                                             {kHouse, "glim"},  {kPost, "frab"},
                                                             {kCar, "wonk"},    {kHedge, "hedge"}};
    for (const auto& [id, name] : classes) {
      ClassInfo info;
      info.id = id;
      info.name = name;
      info.role = ClassNames::shipped().role(name);
      info.kind = ClassNames::shipped().kind(name);
      info.guessed = true;
      info.unknown = !ClassNames::shipped().find(name);
      labels.add(info);
    }
  }
  void mislabel() {
    const auto patchOf = [](const Point& p) {
      return static_cast<std::uint32_t>(97 * std::floor(p.x) + 31 * std::floor(p.y));
    };
    LabelledCloud other_frames = cloud;  // in which the patches are elsewhere
    for (Point& p : cloud.points)
      if (patchOf(p) % 10 == 0) p.label = kStreet + patchOf(p) / 10 % 6;
    for (int i = 0; i < 2; ++i) cloud.append(other_frames);
  }
};

/// Check fix for: towns whose ground had a name that nobody knew had no ground, and right poses in
/// them were hardly ever accepted.
TEST(ClassShapes, ClassesWhoseNamesSayNothingAreJudgedAndTheOthersAreNot) {
  NamedStreet street;
  ASSERT_TRUE(hasUnknown(street.labels));
  for (const bool is_noisy : {false, true}) {
    if (is_noisy) street.mislabel();
    const LabelSet found = rolesByShape(street.labels, street.cloud);
    EXPECT_FALSE(hasUnknown(found));
    EXPECT_EQ(found.kind(kLawn), Kind::road) << "the largest ground";
    EXPECT_EQ(found.kind(kStreet), Kind::terrain);
    EXPECT_EQ(found.role(kStreet), Role::surface);
    EXPECT_EQ(found.kind(kHouse), Kind::building);
    EXPECT_EQ(found.kind(kPost), Kind::other_object) << "what stands alone stays what it is";
    EXPECT_EQ(found.role(kPost), Role::object);
    EXPECT_EQ(found.role(kCar), Role::object);
    EXPECT_EQ(found.kind(kHedge), ClassNames::shipped().kind("hedge"));
  }
}

TEST(ClassShapes, GroundOfAnUnknownNameIsNoneThatHasAName) {
  NamedStreet street;
  ClassInfo lawn = *street.labels.find(kLawn);
  lawn.name = "road";
  lawn.role = Role::surface;
  lawn.kind = Kind::road;
  lawn.unknown = false;
  street.labels.add(lawn);
  EXPECT_EQ(rolesByShape(street.labels, street.cloud).kind(kStreet), Kind::terrain);
}

TEST(ClassShapes, WithoutGroundNothingIsJudged) {
  LabelledCloud posts;
  for (const auto& point : Street(0).cloud.points) {
    if (point.label == kPost) posts.points.push_back(point);
  }
  EXPECT_EQ(rolesByShape(kUnnamed, posts), kUnnamed);
  EXPECT_EQ(rolesByShape(kUnnamed, {}), kUnnamed);
}

TEST(ClassShapes, PointsThatAreNotFiniteCountForNothing) {
  Street street(0);
  for (std::size_t i = 0; i < street.cloud.size(); i += 7) {
    auto& point = street.cloud.points[i];
    (i % 2 == 0 ? point.x : point.z) = std::numeric_limits<float>::quiet_NaN();
  }
  expectStreet(rolesByShape(kUnnamed, street.cloud));
}

}  // namespace
}  // namespace xview
