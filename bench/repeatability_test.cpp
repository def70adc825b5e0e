// SPDX-License-Identifier: BSD-3-Clause
#include "repeatability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "xview/types/random.h"

namespace xview::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<Landmark> randomLandmarks(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Landmark> result;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(-20, 20), y = random.uniform(-20, 20);
    result.push_back({random.below(3), {x, y, random.uniform(-1, 1)}});
  }
  return result;
}

double nearestByHand(const Landmark& l, const std::vector<Landmark>& others, std::size_t except,
                     double reach_m) {
  double best = kInfinity;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (i == except || others[i].label != l.label) continue;
    best = std::min(best, (others[i].position - l.position).norm());
  }
  return best <= reach_m ? best : kInfinity;
}

/// A view with an origin that knows the square [x0, x1) x [y0, y1) of its frame.
PlanView squareView(double x0, double y0, double x1, double y1) {
  PlanView view;
  view.origin_x = -64;
  view.origin_y = 64;
  for (double y = y0; y < y1; y += view.cell_m) {
    for (double x = x0; x < x1; x += view.cell_m) {
      view.known.push_back({static_cast<std::int32_t>(std::floor((x - view.origin_x) / .5 + .5)),
                            static_cast<std::int32_t>(std::floor((y - view.origin_y) / .5 + .5)), 0,
                            true});
    }
  }
  return view;
}

KnownArea everywhere() { return KnownArea(squareView(-25, -25, 25, 25), 0); }

TEST(FindPartners, AgreesWithComparingAllPairs) {
  const auto a = randomLandmarks(300, 1), b = randomLandmarks(200, 2);
  const auto partners = findPartners(a, b, everywhere(), 1.5);
  std::map<std::uint32_t, std::vector<double>> expected;
  for (const Landmark& l : a) expected[l.label].push_back(nearestByHand(l, b, b.size(), 1.5));
  ASSERT_EQ(partners.size(), expected.size());
  for (const auto& [label, distances] : expected) {
    EXPECT_EQ(partners.at(label).distances_m, distances);
    EXPECT_EQ(partners.at(label).unknown, 0u);
  }
}

TEST(FindPartners, ARepeatedSessionRepeatsEverything) {
  const auto a = randomLandmarks(50, 3);
  for (const auto& [label, p] : findPartners(a, a, everywhere(), 1)) {
    EXPECT_DOUBLE_EQ(p.shareWithin(0), 1) << label;
  }
}

TEST(FindPartners, AnotherLabelIsNoPartner) {
  const auto partners = findPartners({{1, {0, 0, 0}}}, {{2, {0, 0, 0}}}, everywhere(), 3);
  ASSERT_EQ(partners.size(), 1u);
  EXPECT_EQ(partners.at(1).distances_m, std::vector<double>{kInfinity});
}

TEST(FindPartners, CountsOnlyWhereTheOtherSessionSawAnything) {
  const KnownArea known(squareView(0, 0, 10, 10), 1);
  const std::vector<Landmark> inside{{0, {5, 5, 0}}}, on_rim{{0, {10.9, 5, 0}}},
      outside{{0, {11.6, 5, 0}}};
  EXPECT_EQ(findPartners(inside, {}, known, 1).at(0).distances_m.size(), 1u);
  EXPECT_EQ(findPartners(on_rim, {}, known, 1).at(0).distances_m.size(), 1u);
  const Partners none = findPartners(outside, {}, known, 1).at(0);
  EXPECT_TRUE(none.distances_m.empty());
  EXPECT_EQ(none.unknown, 1u);
  EXPECT_TRUE(std::isnan(none.shareWithin(1)));
}

TEST(FindPartners, PositionsThatAreNoNumbersHaveNoPartner) {
  const Landmark broken{0, {std::nan(""), 0, 0}};
  EXPECT_EQ(findPartners({broken}, {broken}, everywhere(), 1).at(0).unknown, 1u);
  const Partners sound = findPartners({{0, {0, 0, 0}}}, {broken}, everywhere(), 1).at(0);
  EXPECT_EQ(sound.distances_m, std::vector<double>{kInfinity});
}

TEST(NeighbourDistances, AgreeWithComparingAllPairs) {
  const auto a = randomLandmarks(300, 4);
  std::map<std::uint32_t, std::vector<double>> expected;
  for (std::size_t i = 0; i < a.size(); ++i)
    expected[a[i].label].push_back(nearestByHand(a[i], a, i, 2));
  EXPECT_EQ(neighbourDistances(a, 2), expected);
}

TEST(NeighbourDistances, ADuplicateShowsAsZero) {
  const std::vector<Landmark> twice{{7, {1, 2, 3}}, {7, {1, 2, 3}}};
  EXPECT_EQ(neighbourDistances(twice, 1).at(7), (std::vector<double>{0, 0}));
}

TEST(NeighbourDistances, ALonelyLandmarkHasNone) {
  EXPECT_EQ(neighbourDistances({{7, {1, 2, 3}}}, 1).at(7), std::vector<double>{kInfinity});
}

TEST(LandmarksOf, AViewAreItsSamplesInItsFrame) {
  PlanView view;
  view.origin_x = 100;
  view.origin_y = -50;
  view.origin_z = 3;
  view[Channel::pole] = {{1, 2, .5f}, {1.1f, 2, .5f}};
  const auto landmarks = landmarksOf(view, 4);
  ASSERT_EQ(landmarks.size(), 2u) << "objects are not thinned";
  EXPECT_EQ(landmarks[0].label, static_cast<std::uint32_t>(Channel::pole));
  EXPECT_EQ(landmarks[0].position, Eigen::Vector3d(101, -48, 3.5));
}

TEST(LandmarksOf, SurfacesOfAViewAreThinnedPerBlockAndChannel) {
  PlanView view;
  view[Channel::road] = {{.1f, .1f, 0}, {.9f, .9f, 0}, {1.1f, .1f, 0}};
  view[Channel::building] = {{.5f, .5f, 0}};
  EXPECT_EQ(landmarksOf(view, 1).size(), 3u);
  EXPECT_EQ(landmarksOf(view, 0).size(), 4u);
}

TEST(Landmarks, FlattenedAfterAMoveLieInThePlane) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 1, 2, 3;
  const auto flat = flattened(moved({{5, {1, 1, 1}}}, T));
  ASSERT_EQ(flat.size(), 1u);
  EXPECT_EQ(flat[0].label, 5u);
  EXPECT_EQ(flat[0].position, Eigen::Vector3d(2, 3, 0));
}

}  // namespace
}  // namespace xview::bench
