// SPDX-License-Identifier: BSD-3-Clause
#include "place/clean_labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "scenes.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {

namespace {

using namespace test;

void fill(LabelImage& image, int x0, int y0, int x1, int y1, std::uint16_t label) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) image.at(x, y) = label;
  }
}

std::size_t countOf(const LabelImage& image, std::uint16_t label) {
  return static_cast<std::size_t>(std::count(image.pixels.begin(), image.pixels.end(), label));
}

/// boundary_px for `pixels` of an image of this width.
int atWidthOfPaper(int pixels, int width) { return 1280 * pixels / width + 1; }

/// Sky above, a building, road below.
LabelImage street() {
  LabelImage image(120, 80, kSky);
  fill(image, 20, 15, 90, 50, kBuilding);
  fill(image, 0, 50, 120, 80, kRoad);
  return image;
}

/// 20x20 pixels of specks of 2x2, no two of one class touching.
void fillWithSpecks(LabelImage& image, const std::array<std::uint16_t, 4>& classes) {
  for (int y = 10; y < 30; y += 2) {
    for (int x = 10; x < 30; x += 2) {
      const auto which = static_cast<std::size_t>(x / 2 % 2 + y / 2 % 2 * 2);
      fill(image, x, y, x + 2, y + 2, classes[which]);
    }
  }
}

TEST(CleanLabels, LeaveAnImageWithoutSpecksAsItIs) {
  EXPECT_EQ(cleanLabels(street(), townLabels(), {}).pixels, street().pixels);
}

TEST(CleanLabels, KeepAPoleThreePixelsWide) {
  LabelImage image = street();
  fill(image, 50, 10, 53, 70, kPole);  // before sky, building and road
  for (const int boundary_px : {0, atWidthOfPaper(4, 120)}) {
    CleanOptions options;
    options.boundary_px = boundary_px;
    const LabelImage cleaned = cleanLabels(image, townLabels(), options);
    for (int y = 10; y < 70; ++y) {
      for (int x = 50; x < 53; ++x) ASSERT_EQ(cleaned.at(x, y), kPole) << x << ", " << y;
    }
    EXPECT_EQ(countOf(cleaned, kPole), 180u);
  }
}

TEST(CleanLabels, FillSpecksFromTheClassAround) {
  LabelImage image = street();
  fill(image, 40, 25, 43, 28, kCar);
  fill(image, 60, 60, 61, 61, kBuilding);
  image.at(70, 30) = kVoid;
  EXPECT_EQ(cleanLabels(image, townLabels(), {}).pixels, street().pixels);
}

TEST(CleanLabels, LeaveSpecksUnlabelledWhereNothingClosesOverThem) {
  LabelImage image(60, 60, kSky);
  fillWithSpecks(image, {kCar, kBench, kBuilding, kRoad});
  const LabelImage cleaned = cleanLabels(image, townLabels(), {});
  EXPECT_EQ(countOf(cleaned, kCar), 0u);
  EXPECT_EQ(countOf(cleaned, kVoid), 400u) << "wider than what the sky closes over";
}

TEST(CleanLabels, DropObjectsBelowTheLimitButPolesOnlyBelowAQuarter) {
  LabelImage image = street();
  fill(image, 10, 20, 11, 24, kPole);   // 4 px in the sky
  fill(image, 10, 30, 11, 32, kPole);   // 2 px
  fill(image, 30, 60, 35, 62, kBench);  // 10 px on the road
  fill(image, 60, 60, 66, 62, kBench);  // 12 px
  const LabelImage cleaned = cleanLabels(image, townLabels(), {});
  EXPECT_EQ(countOf(cleaned, kPole), 4u);
  EXPECT_EQ(countOf(cleaned, kBench), 12u);
}

TEST(CleanLabels, DoNotFillGapsBetweenThings) {
  LabelImage image = street();
  fill(image, 40, 55, 50, 65, kCar);
  fill(image, 54, 55, 64, 65, kCar);  // 4 px of road between
  EXPECT_EQ(cleanLabels(image, townLabels(), {}).pixels, image.pixels);
}

TEST(CleanLabels, CloseGapsAndFrayedBoundariesWhenTold) {
  LabelImage image = street();
  for (int x = 20; x < 90; x += 4)
    fill(image, x, 12, x + 2, 15, kBuilding);  // a comb against the sky
  CleanOptions options;
  options.boundary_px = atWidthOfPaper(4, 120);
  const LabelImage cleaned = cleanLabels(image, townLabels(), options);
  for (int x = 20; x < 90; ++x) EXPECT_EQ(cleaned.at(x, 13), kBuilding) << x;
  EXPECT_EQ(cleaned.at(40, 11), kSky);
  EXPECT_EQ(countOf(cleaned, kRoad), countOf(street(), kRoad));
}

TEST(CleanLabels, DoNotCloseOverTheInnerCornerOfAnL) {
  // An L of building: the pixels beyond its arms are not closed over, although they are inside the
  // bounding box.
  LabelImage image(80, 80, kRoad);
  fill(image, 10, 10, 20, 70, kBuilding);
  fill(image, 10, 60, 70, 70, kBuilding);
  CleanOptions options;
  options.boundary_px = atWidthOfPaper(4, 80);
  EXPECT_EQ(cleanLabels(image, townLabels(), options).pixels, image.pixels);
}

TEST(CleanLabels, NeverUseTheIdOfARealClassForUnlabelled) {
  LabelSet set("ids from zero");
  ClassInfo road;
  road.id = 0;
  road.name = "road";
  road.role = Role::surface;
  set.add(road);
  ClassInfo car = road;
  car.id = 1;
  car.role = Role::dynamic;
  set.add(car);
  LabelImage image(40, 40, 9);  // nothing known
  fillWithSpecks(image, {1, 9, 10, 11});
  const LabelImage cleaned = cleanLabels(image, set, {});
  EXPECT_EQ(countOf(cleaned, 0), 0u);
  EXPECT_EQ(set.role(cleaned.at(10, 10)), Role::ignored);
}

TEST(CleanLabels, ChangeNothingButSpecks) {
  Random random(5);
  LabelImage image = street();
  for (int i = 0; i < 200; ++i) {
    const int x = static_cast<int>(random.below(110)), y = static_cast<int>(random.below(77));
    fill(image, x, y, x + 1 + static_cast<int>(random.below(9)),
         y + 1 + static_cast<int>(random.below(3)), static_cast<std::uint16_t>(random.below(7)));
  }
  const LabelImage cleaned = cleanLabels(image, townLabels(), {});
  const LabelRegions found = findLabelRegions(image);
  std::size_t changed = 0;
  for (const LabelRun& run : found.runs) {
    const LabelRegion& region = found.regions[run.region];
    for (int x = run.begin; x < run.end; ++x) {
      if (cleaned.at(x, run.row) == region.label) continue;
      ++changed;
      EXPECT_LT(region.pixels, region.label == kPole ? 3 : 12);
    }
  }
  EXPECT_GT(changed, 100u);
}

TEST(CleanLabels, AreMirroredWithTheImage) {
  Random random(6);
  LabelImage image = street();
  for (int i = 0; i < 200; ++i) {
    image.at(static_cast<int>(random.below(120)), static_cast<int>(random.below(80))) = kCar;
  }
  const auto mirrored = [](LabelImage in) {
    for (int y = 0; y < in.height; ++y) {
      std::reverse(&in.at(0, y), &in.at(0, y) + in.width);
    }
    return in;
  };
  EXPECT_EQ(cleanLabels(mirrored(image), townLabels(), {}).pixels,
            mirrored(cleanLabels(image, townLabels(), {})).pixels);
}

TEST(CleanLabels, DisabledOrEmptyDoNothing) {
  LabelImage image = street();
  image.at(5, 5) = kCar;
  CleanOptions options;
  options.enabled = false;
  EXPECT_EQ(cleanLabels(image, townLabels(), options).pixels, image.pixels);
  EXPECT_TRUE(cleanLabels(LabelImage(), townLabels(), {}).empty());
}

/// Check fix for: with every id in use the search for an unused one never ended.
TEST(CleanLabels, WithoutAnIdForPixelsWithoutAClassSaysSo) {
  LabelSet all("all");
  for (std::uint32_t id = 0; id < 65536; ++id) all.add({id, "thing"});
  EXPECT_NE(messageOf<Error>([&] {
              cleanLabels(street(), all, {});
            }).find("label set 'all': all 65536 ids"),
            std::string::npos);
  ClassInfo ignored = *all.find(1);  // the last one that is looked at
  ignored.role = Role::ignored;
  all.add(ignored);
  LabelImage image(3, 3, 5);
  image.at(1, 1) = 6;
  EXPECT_EQ(countOf(cleanLabels(image, all, {}), 1), 9u) << "all of it is specks";
}

TEST(CleanLabels, OfAnImageOfOnePixelIsUnlabelled) {
  EXPECT_EQ(cleanLabels(LabelImage(1, 1, kCar), townLabels(), {}).at(0, 0), kVoid);
}

}  // namespace
}  // namespace xview
