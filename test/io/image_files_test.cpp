// SPDX-License-Identifier: BSD-3-Clause
#include "io/image_files.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using test::messageOf;
using test::pngBytes;
using test::writeText;

class ImageFiles : public ::testing::Test {
 protected:
  ImageFiles() {
    camera_.width = 3;
    camera_.height = 2;
    camera_.fx = camera_.fy = 100;
    camera_.depth_scale = 0.01;
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    writeText(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string depthMessage(const std::string& path) const {
    return messageOf([&] { readDepth(path, camera_); });
  }
  std::string labelMessage(const std::string& path) const {
    return messageOf([&] { readLabels(path); });
  }

  test::TemporaryFolder folder_;
  Camera camera_;
};

TEST_F(ImageFiles, IntegerDepthIsScaledToMetres) {
  const auto path = write("a.png", pngBytes(3, 2, 1, 16, {0, 1, 100, 250, 1000, 65535}));
  const DepthImage depth = readDepth(path, camera_);
  EXPECT_EQ(depth.pixels, (std::vector<float>{0, 0.01f, 1, 2.5f, 10, 655.35f}));
}

TEST_F(ImageFiles, PfmIsReadInBothByteOrdersFromTheBottomUp) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6.5f};
  for (const bool little_endian : {true, false}) {
    const auto path = write("a.pfm", test::pfmBytes(3, 2, values, little_endian));
    EXPECT_EQ(readDepth(path, camera_).pixels, values) << little_endian;
  }
}

TEST_F(ImageFiles, FloatTiffAndExrAreMetres) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6.5f};
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  for (const char* name : {"a.tiff", "a.exr"}) {
    cv::Mat image(2, 3, CV_32F);
    std::copy(values.begin(), values.end(), image.ptr<float>());
    ASSERT_TRUE(cv::imwrite(folder_ / name, image)) << name;
    EXPECT_EQ(readDepth(folder_ / name, camera_).pixels, values) << name;
  }
}

TEST_F(ImageFiles, WhatIsNoMeasurementBecomesZero) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const auto path = write("a.pfm", test::pfmBytes(3, 2, {nan, inf, -inf, -1, 0, 7}, true));
  EXPECT_EQ(readDepth(path, camera_).pixels, (std::vector<float>{0, 0, 0, 0, 0, 7}));
}

TEST_F(ImageFiles, DepthOfAnotherTypeIsNamed) {
  const auto eight = write("a.png", pngBytes(3, 2, 1, 8, {1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(depthMessage(eight), eight +
                                     ": expected depth of 16-bit unsigned or 32-bit float, 1 "
                                     "channel, found 8-bit unsigned, 1 channel");
  const auto rgb = write("b.png", pngBytes(3, 2, 3, 16, std::vector<std::uint16_t>(18, 7)));
  EXPECT_NE(depthMessage(rgb).find("found 16-bit unsigned, 3 channels"), std::string::npos);
}

TEST_F(ImageFiles, DepthOfAnotherSizeThanTheCameraIsRefused) {
  const auto path = write("a.png", pngBytes(2, 2, 1, 16, {1, 2, 3, 4}));
  EXPECT_EQ(depthMessage(path), path + ": depth of 2 x 2 pixels, the camera has 3 x 2");
}

/// What the decoder would make room for is compared first.
TEST_F(ImageFiles, TheSizeInTheHeaderIsComparedWithTheCameraBeforePixelsAreUnpacked) {
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  for (const char* name : {"a.tiff", "a.exr"}) {
    const std::string path = folder_ / name;
    ASSERT_TRUE(cv::imwrite(path, cv::Mat(7, 33, CV_32F, 1.0F)));
    EXPECT_EQ(depthMessage(path), path + ": depth of 33 x 7 pixels, the camera has 3 x 2");
    const std::string bytes = test::readText(path);
    if (std::string(name) != "a.exr") continue;  // the header of the other stands at its end
    writeText(path, bytes.substr(0, bytes.size() / 2));
    EXPECT_EQ(depthMessage(path), path + ": depth of 33 x 7 pixels, the camera has 3 x 2");
  }
  const auto png = write("a.png", pngBytes(30000u, 300u, 0, 16, std::string(20000, 'x')));
  EXPECT_EQ(depthMessage(png), png + ": depth of 30000 x 300 pixels, the camera has 3 x 2");
}

/// OpenEXR makes room for an attribute before it reads it: 310 bytes asked for gigabytes.
TEST_F(ImageFiles, AttributesOfAnExrThatAreLargerThanTheFileAreRefused) {
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  ASSERT_TRUE(cv::imwrite(folder_ / "a.exr", cv::Mat(2, 3, CV_32F, 1.0F)));
  std::string bytes = test::readText(folder_ / "a.exr");
  const std::string name("screenWindowWidth\0float\0", 24);
  const std::size_t at = bytes.find(name);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(
      at, name.size() + 4,
      std::string("screenWindowWidth\0flaot\0", 24) + test::raw(std::uint32_t{0x7FFFFFF0}));
  EXPECT_NE(depthMessage(write("b.exr", bytes)).find("EXR attribute of 2147483632 bytes"),
            std::string::npos)
      << depthMessage(folder_ / "b.exr");
}

TEST_F(ImageFiles, AnImageWhoseSizeIsNotKnownHasALargestOne) {
  std::string jpeg("\xFF\xD8\xFF\xC0\x00\x11\x08\x7F\xFF\x7F\xFF\x03", 12);
  jpeg += std::string(9, '\1') + "\xFF\xDA\x00\x02\xFF\xD9";
  const auto path = write("a.jpg", jpeg);
  EXPECT_EQ(messageOf([&] { readColors(path); }),
            path + ": image of 32767 x 32767 pixels, expected 67 million at most");
}

TEST_F(ImageFiles, JpegsAreReadToTheirEnd) {
  ASSERT_TRUE(cv::imwrite(folder_ / "a.jpg", cv::Mat(40, 60, CV_8UC3, cv::Scalar(10, 20, 200))));
  const ColorImage colors = readColors(folder_ / "a.jpg");
  EXPECT_EQ(colors.width, 60);
  EXPECT_NEAR(colors.at(30, 20)[0], 200, 8);
  const std::string bytes = test::readText(folder_ / "a.jpg");
  for (std::size_t size = 0; size < bytes.size(); size += 7)
    EXPECT_NE(messageOf([&] { readColors(write("cut.jpg", bytes.substr(0, size))); }), "") << size;
}

TEST_F(ImageFiles, OtherFormatsAreNotTried) {
  ASSERT_TRUE(cv::imwrite(folder_ / "a.bmp", cv::Mat(2, 3, CV_8U, 1)));
  EXPECT_NE(labelMessage(folder_ / "a.bmp").find("expected a PNG, TIFF, EXR or JPEG image"),
            std::string::npos);
}

TEST_F(ImageFiles, LabelsMayHaveEightOrSixteenBits) {
  const auto narrow = write("a.png", pngBytes(2, 2, 1, 8, {0, 1, 128, 255}));
  EXPECT_EQ(readLabels(narrow).pixels, (std::vector<std::uint16_t>{0, 1, 128, 255}));
  const auto wide = write("b.png", pngBytes(2, 2, 1, 16, {0, 259, 4000, 65535}));
  EXPECT_EQ(readLabels(wide).pixels, (std::vector<std::uint16_t>{0, 259, 4000, 65535}));
}

TEST_F(ImageFiles, LabelsWithColoursOrAPaletteAreRefused) {
  const auto rgb = write("a.png", pngBytes(1, 1, 3, 8, {7, 7, 7}));
  EXPECT_EQ(labelMessage(rgb), rgb +
                                   ": expected class ids as 8 or 16-bit unsigned, 1 channel, "
                                   "found 8-bit unsigned, 3 channels");
  const auto palette = write("b.png", pngBytes(1u, 1u, 3, 8, std::string(2, '\0')));
  EXPECT_NE(labelMessage(palette).find("without a palette, found 8-bit palette"),
            std::string::npos);
  const auto one_bit = write("c.png", pngBytes(8u, 1u, 0, 1, std::string("\0\x55", 2)));
  EXPECT_NE(labelMessage(one_bit).find("found 1-bit grey"), std::string::npos);
}

TEST_F(ImageFiles, EveryTruncationOfAPngIsRefusedWithItsPath) {
  const std::string whole = pngBytes(3, 2, 1, 8, {0, 1, 2, 3, 4, 5});
  ASSERT_EQ(labelMessage(write("whole.png", whole)), "");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto path = write("cut.png", whole.substr(0, size));
    EXPECT_EQ(labelMessage(path).find(path + ": "), 0u) << size;
  }
}

TEST_F(ImageFiles, EveryFlippedBitOfAPngIsRefused) {
  const std::string whole = pngBytes(3, 2, 1, 8, {0, 1, 2, 3, 4, 5});
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    EXPECT_NE(labelMessage(write("flip.png", damaged)), "") << "byte " << i;
  }
}

TEST_F(ImageFiles, APngThatCannotHoldItsPixelsIsRefusedBeforeAnythingIsAllocated) {
  EXPECT_NE(labelMessage(write("a.png", pngBytes(30000u, 30000u, 0, 16, "x")))
                .find("cannot hold 30000 x 30000 pixels"),
            std::string::npos);
  EXPECT_NE(labelMessage(write("b.png", pngBytes(4000000000u, 1u, 0, 8, "x"))), "");
  EXPECT_NE(labelMessage(write("c.png", pngBytes(0u, 5u, 0, 8, "x"))), "");
}

TEST_F(ImageFiles, DamagedPfmIsRefusedWithItsPlace) {
  const std::string whole = test::pfmBytes(3, 2, {1, 2, 3, 4, 5, 6}, true);
  EXPECT_NE(depthMessage(write("a.pfm", whole.substr(0, whole.size() - 1)))
                .find("expected 24 bytes for 3 x 2 pixels, found 23"),
            std::string::npos);
  EXPECT_NE(depthMessage(write("b.pfm", whole + "x")), "");
  EXPECT_NE(depthMessage(write("c.pfm", "PF\n3 2\n-1\n")).find("colour PFM"), std::string::npos);
  EXPECT_NE(depthMessage(write("d.pfm", "Pf\n3 -2\n-1\n")).find("d.pfm:2: "), std::string::npos);
  EXPECT_NE(depthMessage(write("e.pfm", "Pf\n3 2\n0\n")).find("e.pfm:3: "), std::string::npos);
  EXPECT_NE(depthMessage(write("f.pfm", "Pf\n")), "");
  EXPECT_NE(depthMessage(write("g.pfm", "")), "");
}

TEST_F(ImageFiles, WhatIsNoImageIsRefused) {
  for (const char* name : {"a.png", "a.tiff", "a.exr"}) {
    EXPECT_EQ(labelMessage(write(name, "this is no image")).find(folder_ / name), 0u) << name;
    EXPECT_EQ(labelMessage(write(name, "")).find(folder_ / name), 0u) << name;
  }
  EXPECT_NE(labelMessage(folder_ / "absent.png").find("cannot open"), std::string::npos);
  EXPECT_NE(labelMessage(folder_.path()).find("folder"), std::string::npos);
}

/// A TIFF of the program's own byte order whose strips are said to have so many rows.
std::string withRowsPerStrip(std::string tiff, std::uint32_t rows) {
  constexpr std::uint16_t kRowsPerStrip = 278, kLong = 4;
  std::uint32_t directory = 0;
  std::uint16_t entries = 0;
  std::memcpy(&directory, &tiff[4], 4);
  std::memcpy(&entries, &tiff[directory], 2);
  for (std::size_t entry = directory + 2; entries-- > 0; entry += 12) {
    if (std::memcmp(&tiff[entry], &kRowsPerStrip, 2) != 0) continue;
    std::memcpy(&tiff[entry + 2], &kLong, 2);
    std::memcpy(&tiff[entry + 8], &rows, 4);
  }
  return tiff;
}

/// Check fix for: the decoder made room for all rows of a strip, in an image of two.
TEST_F(ImageFiles, StripsOfATiffAreNoLargerThanAnImage) {
  ASSERT_TRUE(cv::imwrite(folder_ / "a.tiff", cv::Mat(2, 3, CV_16U, cv::Scalar(7))));
  const std::string tiff = test::readText(folder_ / "a.tiff");
  for (const std::uint32_t rows : {2u, 1000u, 0xFFFFFFFFu}) {
    const auto path = write("b.tiff", withRowsPerStrip(tiff, rows));
    EXPECT_EQ(readLabels(path).pixels, std::vector<std::uint16_t>(6, 7)) << rows;
  }
  EXPECT_NE(labelMessage(write("c.tiff", withRowsPerStrip(tiff, 1698264147)))
                .find("3 x 2 pixels in strips of 5094792441 pixels"),
            std::string::npos);
}

TEST_F(ImageFiles, WrittenImagesAreReadBack) {
  DepthImage depth(3, 2);
  depth.pixels = {0, 0.01f, 1.004f, 655.35f, 700, -1};
  writeDepthPng(folder_ / "depth.png", depth, 0.01);
  EXPECT_EQ(readDepth(folder_ / "depth.png", camera_).pixels,
            (std::vector<float>{0, 0.01f, 1, 655.35f, 0, 0}));
  for (const std::uint16_t largest : {255, 256, 65535}) {
    LabelImage labels(3, 2);
    labels.pixels = {0, 1, 2, 3, 4, largest};
    writeLabelPng(folder_ / "label.png", labels);
    EXPECT_EQ(readLabels(folder_ / "label.png").pixels, labels.pixels);
  }
  EXPECT_EQ(cv::imread(folder_ / "label.png", cv::IMREAD_UNCHANGED).at<std::uint16_t>(1, 2), 65535);
  EXPECT_THROW(writeLabelPng(folder_ / "none.png", LabelImage()), Error);
  EXPECT_THROW(writeLabelPng(folder_ / "absent/label.png", LabelImage(1, 1)), Error);
}

TEST_F(ImageFiles, CameraIsReadBackExactly) {
  Camera camera = camera_;
  camera.fx = 532.740352;
  camera.cx = 1.0 / 3;
  camera.depth_is_range = true;
  writeCamera(folder_ / "camera.yaml", camera);
  const Camera read = readCamera(folder_ / "camera.yaml");
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_EQ(read.fx, camera.fx);
  EXPECT_EQ(read.cx, camera.cx);
  EXPECT_EQ(read.depth_scale, 0.01);
  EXPECT_TRUE(read.depth_is_range);
  EXPECT_EQ(read.min_range_m, 0);
  EXPECT_EQ(read.max_range_m, std::numeric_limits<double>::infinity());
}

TEST_F(ImageFiles, CameraMayHaveRangesOfItsOwn) {
  Camera camera = camera_;
  camera.min_range_m = 0.45;
  camera.max_range_m = 1.0 / 3 + 12;
  writeCamera(folder_ / "camera.yaml", camera);
  EXPECT_EQ(readCamera(folder_ / "camera.yaml").min_range_m, 0.45);
  EXPECT_EQ(readCamera(folder_ / "camera.yaml").max_range_m, camera.max_range_m);
  camera.max_range_m = 0.4;
  writeCamera(folder_ / "camera.yaml", camera);
  EXPECT_NE(
      messageOf([&] { readCamera(folder_ / "camera.yaml"); }).find("0 <= min_range < max_range"),
      std::string::npos);
}

TEST_F(ImageFiles, CameraSaysAllThatIsMissingAndWhereTheRestIsWrong) {
  const auto messageFor = [&](const std::string& text) {
    const auto path = write("camera.yaml", text);
    return messageOf([&] { readCamera(path); });
  };
  const std::string path = folder_ / "camera.yaml";
  const std::string rest = "fx: 1\nfy: 1\ncx: 0\ncy: 0\ndepth_scale: 1\n";
  EXPECT_EQ(messageFor("width: 3\nheight: 2\nfx: 1\ncy: 0\n"),
            path + ": missing: fy, cx, depth_scale");
  EXPECT_EQ(messageFor("width: 3\nheight: 2\nsensor: zed\ndepth: planar\n" + rest), "");
  EXPECT_EQ(messageFor("width: 3\nheigth: 2\n" + rest),
            path + ":2: unknown key 'heigth'; the nearest known one is height");
  EXPECT_EQ(messageFor("width: 0\nheight: 2\n" + rest),
            path + ":1: width: expected a whole number in [1, 32768], found '0'");
  EXPECT_EQ(messageFor("width: 3\nheight: 2\ndepth: ray\n" + rest),
            path + ":3: depth: expected range or planar, found 'ray'");
  EXPECT_EQ(messageFor("width: 3\nheight: 2\nfx: -1\nfy: 1\ncx: 0\ncy: 0\ndepth_scale: 1\n"),
            path + ":3: fx: expected a number above 0");
  EXPECT_EQ(messageFor("width: 3\nheight: 2\nfx: .nan\nfy: 1\ncx: 0\ncy: 0\ndepth_scale: 1\n"),
            path + ":3: fx: expected a number, found '.nan'");
  EXPECT_NE(messageFor(""), "");
  EXPECT_NE(messageFor("- 1\n"), "");
  EXPECT_EQ(messageFor("width: [\n").find(path + ":"), 0u);
  EXPECT_NE(messageFor(std::string(5000, '[')), "");
}

}  // namespace
}  // namespace xview::io
