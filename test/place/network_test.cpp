// SPDX-License-Identifier: BSD-3-Clause
// Networks of one layer.
#include "place/network.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/image_files.h"
#include "support/onnx.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview {
namespace {

using test::onnxModel;
using test::onnxScores;

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
  const auto network = Network::open(write("a.onnx", onnxScores(kRedGreenBlue)), input);
  const LabelImage labels = network->label(halves(), 6, 4);
  EXPECT_EQ(labels.at(0, 0), 7);
  EXPECT_EQ(labels.at(5, 3), 26);
}

TEST_F(Networks, ColoursComeInTheOrderOfTheConfiguration) {
  NetworkInput input;
  input.is_rgb = false;
  const auto network = Network::open(write("a.onnx", onnxScores(kRedGreenBlue)), input);
  EXPECT_EQ(network->label(halves(), 6, 4).at(0, 0), 2);
}

TEST_F(Networks, MeanAndDeviationAreTakenOff) {
  NetworkInput input;
  input.mean = {1, 0, 0};  // red becomes 0, everything else negative in the first channel
  input.std = {1, 1, 0.01};
  const auto network =
      Network::open(write("a.onnx", onnxScores({{0, 0, -1}, {-0.1F, 0, 0}})), input);
  EXPECT_EQ(network->label(halves(), 6, 4).at(5, 0), 1);
}

TEST_F(Networks, AnswersAreBroughtToTheSizeOfTheDepth) {
  NetworkInput input;
  input.width = 6, input.height = 4;
  const auto network = Network::open(write("a.onnx", onnxScores(kRedGreenBlue)), input);
  const LabelImage labels = network->label(halves(), 60, 40);
  EXPECT_EQ(labels.width, 60);
  EXPECT_EQ(labels.at(2, 2), 0);
  EXPECT_EQ(labels.at(57, 37), 2);
}

/// One channel is no score but the number of the class.
TEST_F(Networks, OneChannelHoldsTheClassesThemselves) {
  NetworkInput input;
  const auto network = Network::open(write("a.onnx", onnxScores({{5.1F, 0, 9.2F}})), input);
  const LabelImage labels = network->label(halves(), 6, 4);
  EXPECT_EQ(labels.at(0, 0), 5);
  EXPECT_EQ(labels.at(5, 0), 9);
}

TEST_F(Networks, ThatOpenCvCannotReadNameTheLayer) {
  const std::string path = write("b.onnx", onnxModel("Frobnicate", "", false));
  const std::string said =
      test::messageOf<Error>([&] { Network::open(path, {})->label(halves(), 6, 4); });
  EXPECT_EQ(said.find(path), 0u) << said;
  EXPECT_NE(said.find("Frobnicate"), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
}

TEST_F(Networks, ThatAreNoneAreRefused) {
  EXPECT_THROW(Network::open(write("c.onnx", "no network"), {}), Error);
  EXPECT_THROW(Network::open(folder_ / "absent.onnx", {}), Error);
}

TEST_F(Networks, ClassesWithoutAnIdAreAnError) {
  NetworkInput input;
  input.ids = {7, 8};
  const auto network = Network::open(write("a.onnx", onnxScores(kRedGreenBlue)), input);
  EXPECT_THROW(network->label(halves(), 6, 4), Error);
}

/// As of a network whose classes come last, or that names the whole image.
TEST_F(Networks, WhoseAnswersAreNoPixelsOfItsClassesAreRefused) {
  NetworkInput input;
  input.ids = {7, 8, 26, 33};
  const auto classes_missing = Network::open(write("a.onnx", onnxScores(kRedGreenBlue)), input);
  EXPECT_THROW(classes_missing->label(halves(), 6, 4), Error);
  input.height = 1;
  const auto one_row = Network::open(write("b.onnx", onnxScores({{1, 0, 0}}, 1, 6)), input);
  EXPECT_THROW(one_row->label(halves(), 6, 4), Error);
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
}  // namespace xview
