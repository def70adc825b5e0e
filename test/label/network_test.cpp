// SPDX-License-Identifier: BSD-3-Clause
// Networks of one layer, written here as ONNX by hand.
#include <gtest/gtest.h>
#include <cstring>
#include <fstream>

#include "support/test_data.h"
#include "xview/io/image_files.h"
#include "xview/label/network.h"
#include "xview/types/error.h"

namespace xview::label {
namespace {

// ---- protobuf

std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>(value | 0x80);
  return bytes + static_cast<char>(value);
}
std::string number(int field, std::uint64_t value) {
  return varint(static_cast<std::uint64_t>(field) << 3) + varint(value);
}
std::string text(int field, const std::string& bytes) {
  return varint(static_cast<std::uint64_t>(field) << 3 | 2) + varint(bytes.size()) + bytes;
}

std::string tensor(const std::string& name, const std::vector<std::uint64_t>& dims,
                   const std::vector<float>& values) {
  std::string bytes;
  for (const std::uint64_t d : dims) bytes += number(1, d);
  const std::string raw(reinterpret_cast<const char*>(values.data()),
                        values.size() * sizeof(float));
  return bytes + number(2, 1) + text(8, name) + text(9, raw);
}

std::string port(const std::string& name, const std::vector<std::uint64_t>& dims) {
  std::string shape;
  for (const std::uint64_t d : dims) shape += text(1, number(1, d));
  return text(1, name) + text(2, text(1, number(1, 1) + text(2, shape)));
}

/// y = op(x, weights) with 1 x 3 x 4 x 6 pixels in.
std::string model(const std::string& op, const std::string& weights, bool has_weights) {
  std::string node = text(1, "x");
  if (has_weights) node += text(1, "w");
  node += text(2, "y") + text(3, "only") + text(4, op);
  if (has_weights)  // an attribute of integers
    node += text(
        5, text(1, "kernel_shape") + number(8, 1) + number(8, 1) + varint(20 << 3) + varint(7));
  std::string graph = text(1, node) + text(2, "graph");
  if (has_weights) graph += text(5, weights);
  graph += text(11, port("x", {1, 3, 4, 6})) + text(12, port("y", {1, 3, 4, 6}));
  return number(1, 7) + text(8, text(1, "") + number(2, 11)) + text(7, graph);
}

/// A convolution of one pixel: a score for each row of the matrix.
std::string scoresOf(const std::vector<std::vector<float>>& matrix) {
  std::vector<float> values;
  for (const auto& row : matrix) values.insert(values.end(), row.begin(), row.end());
  return model("Conv", tensor("w", {matrix.size(), 3, 1, 1}, values), true);
}

class Networks : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  /// Left half red, right half blue.
  static ColorImage halves() {
    ColorImage image(6, 4, {250, 0, 0});
    for (int y = 0; y < 4; ++y) {
      for (int x = 3; x < 6; ++x) image.at(x, y) = {0, 0, 250};
    }
    return image;
  }
  test::TemporaryFolder folder_;
};

const std::vector<std::vector<float>> kRedGreenBlue = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST_F(Networks, ScoresBecomeTheIdsOfTheBestClasses) {
  NetworkInput input;
  input.ids = {7, 8, 26};
  Network network(write("a.onnx", scoresOf(kRedGreenBlue)), input);
  const LabelImage labels = network.label(halves(), 6, 4);
  EXPECT_EQ(labels.at(0, 0), 7);
  EXPECT_EQ(labels.at(5, 3), 26);
}

TEST_F(Networks, ColoursComeInTheOrderOfTheConfiguration) {
  NetworkInput input;
  input.is_rgb = false;
  Network network(write("a.onnx", scoresOf(kRedGreenBlue)), input);
  EXPECT_EQ(network.label(halves(), 6, 4).at(0, 0), 2);
}

TEST_F(Networks, MeanAndDeviationAreTakenOff) {
  NetworkInput input;
  input.mean = {1, 0, 0};  // red becomes 0, everything else negative in the first channel
  input.std = {1, 1, 0.01};
  Network network(write("a.onnx", scoresOf({{0, 0, -1}, {-0.1F, 0, 0}})), input);
  EXPECT_EQ(network.label(halves(), 6, 4).at(5, 0), 1);
}

TEST_F(Networks, AnswersAreBroughtToTheSizeOfTheDepth) {
  NetworkInput input;
  input.width = 6, input.height = 4;
  Network network(write("a.onnx", scoresOf(kRedGreenBlue)), input);
  const LabelImage labels = network.label(halves(), 60, 40);
  EXPECT_EQ(labels.width, 60);
  EXPECT_EQ(labels.at(2, 2), 0);
  EXPECT_EQ(labels.at(57, 37), 2);
}

/// One channel is no score but the number of the class.
TEST_F(Networks, OneChannelHoldsTheClassesThemselves) {
  NetworkInput input;
  Network network(write("a.onnx", scoresOf({{5.1F, 0, 9.2F}})), input);
  const LabelImage labels = network.label(halves(), 6, 4);
  EXPECT_EQ(labels.at(0, 0), 5);
  EXPECT_EQ(labels.at(5, 0), 9);
}

TEST_F(Networks, ThatOpenCvCannotReadNameTheLayer) {
  const std::string path = write("b.onnx", model("Frobnicate", "", false));
  try {
    Network network(path, {});
    network.label(halves(), 6, 4);
    FAIL() << "it was read";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find(path), 0u) << e.what();
    EXPECT_NE(std::string(e.what()).find("Frobnicate"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
  }
}

TEST_F(Networks, ThatAreNoneAreRefused) {
  EXPECT_THROW(Network(write("c.onnx", "no network"), {}), Error);
  EXPECT_THROW(Network(folder_ / "absent.onnx", {}), Error);
}

TEST_F(Networks, ClassesWithoutAnIdAreAnError) {
  NetworkInput input;
  input.ids = {7, 8};
  Network network(write("a.onnx", scoresOf(kRedGreenBlue)), input);
  EXPECT_THROW(network.label(halves(), 6, 4), Error);
}

TEST_F(Networks, AreConfiguredByAFile) {
  const NetworkInput input = io::readNetworkInput(write(
      "a.yaml", "labels: cityscapes\nids: [7, 8]\nwidth: 64\nmean: [0.1, 0.2, 0.3]\norder: bgr\n"));
  EXPECT_EQ(input.labels, "cityscapes");
  EXPECT_EQ(input.ids, (std::vector<std::uint32_t>{7, 8}));
  EXPECT_EQ(input.width, 64);
  EXPECT_EQ(input.height, 0);
  EXPECT_DOUBLE_EQ(input.mean[2], 0.3);
  EXPECT_FALSE(input.is_rgb);
  EXPECT_THROW(io::readNetworkInput(write("b.yaml", "ids: [1]\n")), Error);
  EXPECT_THROW(io::readNetworkInput(write("c.yaml", "labels: x\nstd: [1, 0, 1]\n")), Error);
}

}  // namespace
}  // namespace xview::label
