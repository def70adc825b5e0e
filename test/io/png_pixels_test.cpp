// SPDX-License-Identifier: BSD-3-Clause
// Against filters applied here and against OpenCV's decoder.
#include "io/image_decoding.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "base/random.h"
#include "small_files.h"

namespace xview::io {
namespace {

std::vector<unsigned char> asBytes(const std::string& text) { return {text.begin(), text.end()}; }

cv::Mat decoded(const std::string& file) {
  const auto bytes = asBytes(file);
  return decodePng(checkPng("test.png", bytes), bytes);
}

cv::Mat byOpenCv(const std::string& file) {
  return cv::imdecode(asBytes(file), cv::IMREAD_UNCHANGED);
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

std::string fromHex(const std::string& digits) {
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

/// What a filter of the PNG specification (section 9.2) foretells from left, above and above left.
int foretold(int filter, int left, int above, int corner) {
  if (filter == 1) return left;
  if (filter == 2) return above;
  if (filter == 3) return (left + above) / 2;
  if (filter == 0) return 0;
  const int p = left + above - corner;
  const int a = std::abs(p - left), b = std::abs(p - above), c = std::abs(p - corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

struct PixelKind {
  int color_type, channels, bits;
};

class Filtered : public ::testing::TestWithParam<PixelKind> {};

TEST_P(Filtered, RowsOfEveryFilterGiveThePixelsThatOpenCvGives) {
  const PixelKind kind = GetParam();
  constexpr int kWidth = 37, kHeight = 23;
  const int pixel = kind.channels * kind.bits / 8, row_bytes = kWidth * pixel;
  Random random(7);
  std::vector<std::string> rows(kHeight, std::string(static_cast<std::size_t>(row_bytes), '\0'));
  for (std::string& row : rows) {
    for (char& byte : row) byte = static_cast<char>(random.below(256));
  }
  const auto at = [&](int y, int x) -> int {
    if (y < 0 || x < 0) return 0;
    return static_cast<unsigned char>(
        rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]);
  };
  std::string filtered;
  for (int y = 0; y < kHeight; ++y) {
    const int filter = y < 5 ? y : static_cast<int>(random.below(5));
    filtered += static_cast<char>(filter);
    for (int x = 0; x < row_bytes; ++x) {
      filtered += static_cast<char>(
          at(y, x) - foretold(filter, at(y, x - pixel), at(y - 1, x), at(y - 1, x - pixel)));
    }
  }
  const std::string file = test::pngBytes(kWidth, kHeight, kind.color_type, kind.bits, filtered);
  const cv::Mat image = decoded(file);
  ASSERT_EQ(image.size(), cv::Size(kWidth, kHeight));
  EXPECT_TRUE(same(image, byOpenCv(file)));
  // The first sample of the file is red where there are colours, and the last channel of OpenCV's.
  const int first = kind.channels == 1 ? 0 : 2;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int index = x * kind.channels + first;
      const int expected =
          kind.bits == 8 ? at(y, x * pixel) : at(y, x * pixel) * 256 + at(y, x * pixel + 1);
      const int found =
          kind.bits == 8 ? image.ptr<std::uint8_t>(y)[index] : image.ptr<std::uint16_t>(y)[index];
      ASSERT_EQ(found, expected) << "x " << x << " y " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Filtered,
                         ::testing::Values(PixelKind{0, 1, 8}, PixelKind{0, 1, 16},
                                           PixelKind{2, 3, 8}, PixelKind{2, 3, 16},
                                           PixelKind{6, 4, 8}, PixelKind{6, 4, 16}));

TEST(PngPixels, OfFilesThatOpenCvWroteAreThePixelsThatItReads) {
  for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3, CV_8UC4, CV_16UC4}) {
    cv::Mat image(61, 83, type);
    cv::randu(image, 0, 60000);
    for (const int level : {0, 1, 9}) {
      std::vector<unsigned char> bytes;
      cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, level});
      EXPECT_TRUE(same(decodePng(checkPng("test.png", bytes), bytes), image));
    }
  }
}

TEST(PngPixels, MayBeSpreadOverManyDataChunks) {
  cv::Mat image(300, 300, CV_16UC1);  // more than one of the 8 KiB chunks that libpng writes
  cv::randu(image, 0, 65536);
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  const PngHeader header = checkPng("test.png", bytes);
  ASSERT_GT(header.data.size(), 1u);
  EXPECT_TRUE(same(decodePng(header, bytes), image));
}

/// Rows of the seven passes of an interlaced PNG (section 8.2), without filters.
std::string interlaced(int width, int height, std::size_t pixel, const std::string& pixels) {
  const int first_x[] = {0, 4, 0, 2, 0, 1, 0}, first_y[] = {0, 0, 4, 0, 2, 0, 1};
  const int step_x[] = {8, 8, 4, 4, 2, 2, 1}, step_y[] = {8, 8, 8, 4, 4, 2, 2};
  std::string rows;
  for (int pass = 0; pass < 7; ++pass) {
    if (first_x[pass] >= width) continue;
    for (int y = first_y[pass]; y < height; y += step_y[pass]) {
      rows += '\0';
      for (int x = first_x[pass]; x < width; x += step_x[pass])
        rows += pixels.substr(static_cast<std::size_t>(y * width + x) * pixel, pixel);
    }
  }
  return rows;
}

TEST(PngPixels, OfInterlacedFilesOfEverySizeAreThoseThatOpenCvGives) {
  Random random(9);
  for (const auto& [color, channels, bits] :
       {PixelKind{0, 1, 8}, {0, 1, 16}, {2, 3, 8}, {6, 4, 16}}) {
    const auto pixel = static_cast<std::size_t>(channels * bits / 8);
    for (int width = 1; width <= 9; ++width) {
      for (int height = 1; height <= 9; ++height) {
        std::string pixels(pixel * static_cast<std::size_t>(width * height), '\0');
        for (char& byte : pixels) byte = static_cast<char>(random.below(256));
        const std::string file =
            test::pngBytes(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                           color, bits, interlaced(width, height, pixel, pixels), true);
        EXPECT_TRUE(same(decoded(file), byOpenCv(file)))
            << color << " " << bits << " " << width << " x " << height;
      }
    }
  }
}

TEST(PngPixels, OfGreyWithAlphaAreThoseThatOpenCvGives) {
  for (const int bits : {8, 16}) {
    const std::string file = test::pngBytes(2, 2, 2, bits, {5, 255, 7, 0, 200, 9, 1, 2});
    EXPECT_EQ(decoded(file).channels(), 4);
    EXPECT_TRUE(same(decoded(file), byOpenCv(file))) << bits;
  }
}

TEST(PngPixels, OfATransparentColourAreAsStored) {
  // 1 x 2 grey pixels, 7 and 9, with 7 as the transparent colour.
  const std::string file = fromHex(
      "89504e470d0a1a0a0000000d4948445200000001000000020800000000bceae9fb00000002"
      "74524e530007e8f7589b0000000c49444154789c636067e0040000220011ce22b39e000000"
      "0049454e44ae426082");
  const cv::Mat image = decoded(file);
  ASSERT_EQ(image.size(), cv::Size(1, 2));
  EXPECT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(image.at<std::uint8_t>(0), 7);
  EXPECT_EQ(image.at<std::uint8_t>(1), 9);
}

TEST(PngPixels, OfAPaletteAreNone) {
  EXPECT_TRUE(decoded(test::pngBytes(1u, 1u, 3, 8, std::string(2, '\0'))).empty());
}

TEST(PngPixels, ThatAreTooFewOrHaveAnUnknownFilterAreNone) {
  EXPECT_TRUE(decoded(test::pngBytes(2u, 2u, 0, 8, std::string(5, '\0'))).empty());
  EXPECT_TRUE(decoded(test::pngBytes(2u, 2u, 0, 8, std::string(7, '\0'))).empty());
  EXPECT_TRUE(decoded(test::pngBytes(2u, 1u, 0, 8, std::string("\5\1\1"))).empty());
  EXPECT_FALSE(decoded(test::pngBytes(2u, 1u, 0, 8, std::string("\4\1\1"))).empty());
}

}  // namespace
}  // namespace xview::io
