// SPDX-License-Identifier: BSD-3-Clause
#include "place/clean_labels.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace xview {

namespace {

/// Region number of every pixel by flood fill, in order of the first pixel: the slow truth.
Image<int> floodFill(const LabelImage& labels, const LabelImage& instances) {
  Image<int> region(labels.width, labels.height, -1);
  const auto isSame = [&](int x, int y, int u, int v) {
    return labels.at(x, y) == labels.at(u, v) &&
           (instances.empty() || instances.at(x, y) == instances.at(u, v));
  };
  int count = 0;
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      if (region.at(x, y) >= 0) continue;
      std::vector<std::pair<int, int>> open{{x, y}};
      region.at(x, y) = count;
      while (!open.empty()) {
        const auto [cx, cy] = open.back();
        open.pop_back();
        for (int v = std::max(0, cy - 1); v <= std::min(labels.height - 1, cy + 1); ++v) {
          for (int u = std::max(0, cx - 1); u <= std::min(labels.width - 1, cx + 1); ++u) {
            if (region.at(u, v) >= 0 || !isSame(cx, cy, u, v)) continue;
            region.at(u, v) = count;
            open.emplace_back(u, v);
          }
        }
      }
      ++count;
    }
  }
  return region;
}

Image<int> regionImage(const LabelImage& labels, const LabelRegions& found) {
  Image<int> region(labels.width, labels.height, -1);
  for (const LabelRun& run : found.runs) {
    for (int x = run.begin; x < run.end; ++x) region.at(x, run.row) = static_cast<int>(run.region);
  }
  return region;
}

LabelImage randomImage(int width, int height, std::uint32_t labels, Random& random) {
  LabelImage image(width, height);
  std::uint16_t last = 0;
  for (std::uint16_t& pixel : image.pixels) {
    if (random.uniform() < 0.5) last = static_cast<std::uint16_t>(random.below(labels));
    pixel = last;
  }
  return image;
}

TEST(LabelRegions, AreThoseOfAFloodFill) {
  Random random(3);
  for (int round = 0; round < 40; ++round) {
    const int width = 1 + static_cast<int>(random.below(40));
    const int height = 1 + static_cast<int>(random.below(30));
    const LabelImage labels = randomImage(width, height, 2 + round % 3, random);
    const LabelImage instances = round % 2 ? randomImage(width, height, 2, random) : LabelImage();
    const LabelRegions found = findLabelRegions(labels, instances);
    EXPECT_EQ(regionImage(labels, found).pixels, floodFill(labels, instances).pixels);
  }
}

TEST(LabelRegions, KnowTheirLabelSizeAndBounds) {
  LabelImage labels(10, 6, 1);
  for (int y = 2; y < 5; ++y) {
    for (int x = 3; x < 9; ++x) labels.at(x, y) = 7;
  }
  const LabelRegions found = findLabelRegions(labels);
  ASSERT_EQ(found.regions.size(), 2u);
  const LabelRegion& box = found.regions[1];
  EXPECT_EQ(box.label, 7);
  EXPECT_EQ(box.pixels, 18);
  EXPECT_EQ(box.min_x, 3);
  EXPECT_EQ(box.max_x, 8);
  EXPECT_EQ(box.min_y, 2);
  EXPECT_EQ(box.max_y, 4);
  EXPECT_EQ(found.regions[0].pixels, 42);
}

TEST(LabelRegions, OfAnEmptyImageAreNone) {
  EXPECT_TRUE(findLabelRegions(LabelImage()).regions.empty());
}

}  // namespace
}  // namespace xview
