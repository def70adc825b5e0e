// SPDX-License-Identifier: BSD-3-Clause
// xview label as a command: classes from shapes, and by a network.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "support/onnx.h"
#include "support/program.h"
#include "support/test_data.h"
#include "tools/sequence.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 4, kColumns = 64, kRows = 48;

/// A recording whose images are red, green and blue where it shows building, road and pole.
class LabelCommand : public testing::Test {
 protected:
  void SetUp() override {
    writeSequence(recording_, kFrames);
    fs::create_directories(recording_ + "/rgb");
    for (const auto& entry : fs::directory_iterator(recording_ + "/label")) {
      const cv::Mat labels = cv::imread(entry.path(), cv::IMREAD_UNCHANGED);
      cv::Mat colors(labels.size(), CV_8UC3, cv::Scalar(0, 0, 0));
      colors.setTo(cv::Scalar(0, 0, 250), labels == 2);
      colors.setTo(cv::Scalar(0, 250, 0), labels == 3);
      colors.setTo(cv::Scalar(250, 0, 0), labels == 7);
      const std::string name = entry.path().filename();
      cv::imwrite(recording_ + "/rgb/" + name, colors);
      given_.push_back({name, labels});
    }
    fs::rename(recording_ + "/label", folder_ / "label");
    fs::rename(recording_ + "/classes.yaml", folder_ / "classes.yaml");
    writeText(folder_ / "net.yaml", "labels: " + (folder_ / "classes.yaml") +
                                        "\nids: [0, 2, 3, 7]\nwidth: 64\nheight: 48\n");
  }
  std::string write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  Outcome label(const std::string& net, const std::string& out) {
    return runXview({"label", recording_, out, "--net", net, "--net-config", folder_ / "net.yaml"});
  }
  /// The labels that the network found are those that the colours were painted by.
  void expectGivenLabels(const std::string& out) {
    for (const auto& [name, labels] : given_) {
      const cv::Mat found = cv::imread(out + "/label/" + name, cv::IMREAD_UNCHANGED);
      ASSERT_EQ(found.size(), labels.size()) << name;
      cv::Mat a, b;
      found.convertTo(a, CV_32S), labels.convertTo(b, CV_32S);
      EXPECT_EQ(cv::countNonZero(a != b), 0) << name;
    }
  }

  TemporaryFolder folder_;
  const std::string recording_ = folder_ / "seq";
  std::vector<std::pair<std::string, cv::Mat>> given_;
};

TEST_F(LabelCommand, ANetworkOfScoresLabelsARecordingThatIsThenMapped) {
  // Black scores 0 everywhere, and the first class is the best of equals.
  const std::string net = write(
      "scores.onnx", onnxScores({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, kRows, kColumns));
  const Outcome outcome = label(net, folder_ / "out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expectGivenLabels(folder_ / "out");
  const Outcome map = runXview({"map", folder_ / "out", folder_ / "a.xvm"});
  EXPECT_EQ(map.code, 0) << map.err;
}

TEST_F(LabelCommand, ANetworkOfOneChannelSaysTheClasses) {
  const float one = 255.0F / 250;  // colours come as shares of 255
  const std::string net =
      write("classes.onnx", onnxScores({{one, 2 * one, 3 * one}}, kRows, kColumns));
  const Outcome outcome = label(net, folder_ / "out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expectGivenLabels(folder_ / "out");
}

TEST_F(LabelCommand, IdsOfANetworkAreThoseOfItsLabelSet) {
  writeText(folder_ / "net.yaml",
            "labels: " + (folder_ / "classes.yaml") + "\nids: [0, 2, 3, 77]\n");
  const Outcome outcome =
      label(write("a.onnx", onnxScores({{1, 0, 0}}, kRows, kColumns)), folder_ / "out");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("the id 77, which is no class"), std::string::npos) << outcome.err;
}

TEST_F(LabelCommand, ANetworkThatCannotBeReadIsOneLineThatNamesTheLayer) {
  const std::string net = write("odd.onnx", onnxModel("Frobnicate", "", false, kRows, kColumns));
  const Outcome outcome = label(net, folder_ / "out");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("Frobnicate"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(LabelCommand, ImagesOfTumRgbdAreFoundByTheirTime) {
  std::string depth, rgb, truth;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const std::string number = std::to_string(i),
                      name = std::string(6 - number.size(), '0') + number + ".png";
    const double t = 100 + 0.1 * static_cast<double>(i);
    depth += std::to_string(t) + " depth/" + name + "\n";
    rgb += std::to_string(t + 0.01) + " rgb/" + name + "\n";
    truth += std::to_string(t) + " 0 0 0 0 0 0 1\n";
  }
  fs::remove(recording_ + "/poses.txt");
  writeText(recording_ + "/depth.txt", depth);
  writeText(recording_ + "/rgb.txt", rgb);
  writeText(recording_ + "/groundtruth.txt", truth);
  const std::string net = write(
      "scores.onnx", onnxScores({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, kRows, kColumns));
  const Outcome outcome = label(net, folder_ / "out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expectGivenLabels(folder_ / "out");
  const Outcome raw = runXview({"label", recording_, folder_ / "shapes.pcd"});
  EXPECT_EQ(raw.code, 0) << raw.err;
}

TEST_F(LabelCommand, CloudsAreColouredByClassForPclViewer) {
  const Outcome outcome = runXview({"label", recording_, folder_ / "shapes.pcd"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("classes from shapes: "), std::string::npos) << outcome.err;
  const std::string cloud = readText(folder_ / "shapes.pcd");
  const std::string fields =
      cloud.substr(cloud.find("FIELDS"), cloud.find("SIZE") - cloud.find("FIELDS"));
  EXPECT_NE(fields.find(" rgb"), std::string::npos) << fields;
  EXPECT_NE(fields.find(" label"), std::string::npos) << fields;
}

}  // namespace
}  // namespace xview::test
