// SPDX-License-Identifier: BSD-3-Clause
// What is written to text files, clouds, graphs and recordings is read as it was.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <filesystem>
#include <memory>

#include "base/pose.h"
#include "io/graph_files.h"
#include "io/image_files.h"
#include "map/sample_map.h"
#include "round_trips/generators.h"
#include "search/likelihoods.h"
#include "support/test_data.h"
#include "verdict/verdict.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

namespace gen = rc::gen;
using test::scratch;

RC_GTEST_PROP(TumPoses, ComeBackToNineDecimals, ()) {
  std::vector<StampedPose> poses;
  for (int i = *gen::inRange(1, 8); i > 0; --i)
    poses.push_back({*test::anyNumber(2e9), *test::anyPose()});
  writeTumPoses(scratch("poses.txt"), poses);
  const std::vector<StampedPose> read = readPoses(scratch("poses.txt"));
  RC_ASSERT(read.size() == poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Isometry3d &a = poses[i].T_frame_sensor, &b = read[i].T_frame_sensor;
    RC_ASSERT(std::abs(read[i].stamp_s - poses[i].stamp_s) < 1e-6);
    RC_ASSERT((a.translation() - b.translation()).cwiseAbs().maxCoeff() < 1e-9);
    RC_ASSERT(rotationBetween(a, b) < 1e-7);
  }
}

RC_GTEST_PROP(Matrix, ComesBackBitByBit, ()) {
  const Eigen::Isometry3d T = *test::anyPose();
  const double scale = std::exp(*test::anyNumber(2));
  writeMatrix(scratch("T.txt"), T, scale);
  const Eigen::Affine3d read = readMatrix(scratch("T.txt"));
  RC_ASSERT(read.translation() == T.translation());
  RC_ASSERT(read.linear() == T.linear() * scale);
}

RC_GTEST_PROP(GraphFile, ComesBackBitByBit, ()) {
  const SemanticGraph graph = *test::anyGraph();
  const LabelSet labels = *test::anyLabels();
  writeGraph(scratch("graph.ply"), graph, labels);
  const GraphFile read = readGraph(scratch("graph.ply"));
  RC_ASSERT(test::isSame(read.graph, graph));
  RC_ASSERT(read.graph.space == graph.space);
  RC_ASSERT(read.has_edges);
  RC_ASSERT(read.labels.has_value());
  RC_ASSERT(test::isSame(*read.labels, labels));
}

using Write = void (*)(const std::string&, const LabelledCloud&, const LabelSet*);

/// `far`: coordinates are doubles, of which an origin and single precision are made.
void requireCloudsComeBack(const std::string& path, Write write, bool far) {
  const LabelledCloud cloud = *test::anyCloud(far);
  const LabelSet labels = *test::anyLabels();
  write(path, cloud, &labels);
  RC_ASSERT(test::isSame(*readCloudHeader(path).labels, labels));
  const LabelledCloud read = readCloud(path);
  RC_ASSERT(read.size() == cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point &a = cloud.points[i], &b = read.points[i];
    RC_ASSERT(a.label == b.label);
    RC_ASSERT(a.instance == b.instance);
    RC_ASSERT(a.sigma == b.sigma);
    const double off_m = (cloud.position(i) - read.position(i)).cwiseAbs().maxCoeff();
    RC_ASSERT(off_m <= (far ? 1e-3 : 0));
  }
}

RC_GTEST_PROP(PcdCloud, ComesBackBitByBit, ()) {
  requireCloudsComeBack(scratch("cloud.pcd"), writePcd, false);
}
RC_GTEST_PROP(PcdCloud, FarAwayComesBackToAMillimetre, ()) {
  requireCloudsComeBack(scratch("cloud.pcd"), writePcd, true);
}
RC_GTEST_PROP(PlyCloud, ComesBackBitByBit, ()) {
  requireCloudsComeBack(scratch("cloud.ply"), writePly, false);
}
RC_GTEST_PROP(PlyCloud, FarAwayComesBackToAMillimetre, ()) {
  requireCloudsComeBack(scratch("cloud.ply"), writePly, true);
}

RC_GTEST_PROP(Tiles, HoldAllPointsOfTheCloud, ()) {
  const LabelledCloud cloud = *test::anyCloud(*gen::arbitrary<bool>());
  writeTiles(scratch("tiles"), cloud, *gen::inRange(1, 60));
  const LabelledCloud read = readCloud(scratch("tiles"));
  RC_ASSERT(read.size() == cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    bool found = false;
    for (std::size_t k = 0; k < read.size() && !found; ++k)
      found = read.points[k].label == cloud.points[i].label &&
              (read.position(k) - cloud.position(i)).cwiseAbs().maxCoeff() < 1e-3;
    RC_ASSERT(found);
  }
}

/// Frames that are in memory.
class KeptRecording final : public FrameSource {
 public:
  KeptRecording(Sensor sensor, LabelSet labels, std::vector<Frame> frames)
      : sensor_(sensor), labels_(std::move(labels)), frames_(std::move(frames)) {}
  std::size_t size() const override { return frames_.size(); }
  Eigen::Isometry3d pose(std::size_t i) const override { return frames_[i].T_odom_sensor; }
  double stamp(std::size_t i) const override { return frames_[i].stamp_s; }
  std::int64_t number(std::size_t i) const override { return frames_[i].number; }
  Frame read(std::size_t i) const override { return frames_[i]; }
  Sensor sensor() const override { return sensor_; }
  const LabelSet& labels() const override { return labels_; }
  const std::string& name() const override { return name_; }

 private:
  Sensor sensor_;
  LabelSet labels_;
  std::vector<Frame> frames_;
  std::string name_ = "kept";
};

Frame anyFrame(std::int64_t number, Sensor sensor) {
  Frame frame;
  frame.number = number;
  frame.stamp_s = static_cast<double>(number) / 8;
  frame.sensor = sensor;
  frame.T_odom_sensor = *test::anyPose();
  if (sensor == Sensor::lidar) {
    frame.cloud = *test::anyCloud(false);
    for (Point& p : frame.cloud.points) {
      p.label &= 0xFFFFU;
      p.instance &= 0xFFFFU;
    }
    return frame;
  }
  frame.camera = {4, 3, 2.5, 2.75, 1.5, 1, 1. / 256, false, 0, frame.camera.max_range_m};
  frame.depth = DepthImage(4, 3);
  frame.label = frame.instance = LabelImage(4, 3);
  for (std::size_t i = 0; i < frame.depth.pixels.size(); ++i) {
    frame.depth.pixels[i] = static_cast<float>(*gen::arbitrary<std::uint16_t>()) / 256;
    frame.label.pixels[i] = *gen::arbitrary<std::uint16_t>();
    frame.instance.pixels[i] = *gen::arbitrary<std::uint16_t>();
  }
  return frame;
}

/// Poses of scans are KITTI lines with all digits, those of cameras TUM lines with nine decimals.
void requireRecordingsComeBack(Sensor sensor) {
  const LabelSet labels = *test::anyLabels(0xFFFF);
  std::vector<Frame> frames;
  for (std::int64_t i = 0; i < *gen::inRange(1, 4); ++i) frames.push_back(anyFrame(i, sensor));
  const KeptRecording kept(sensor, labels, frames);
  const std::string folder = scratch(sensor == Sensor::lidar ? "scans" : "images");
  writeRecording(folder, kept, {}, 1);
  const std::unique_ptr<FrameSource> read = openRecording(folder);
  RC_ASSERT(test::isSame(read->labels(), labels));
  RC_ASSERT(read->size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame frame = read->read(i);
    const Eigen::Matrix4d off = frame.T_odom_sensor.matrix() - frames[i].T_odom_sensor.matrix();
    RC_ASSERT(off.cwiseAbs().maxCoeff() < 1e-8);
    RC_ASSERT(frame.stamp_s == frames[i].stamp_s);
    RC_ASSERT(frame.depth.pixels == frames[i].depth.pixels);
    RC_ASSERT(frame.label.pixels == frames[i].label.pixels);
    RC_ASSERT(frame.instance.pixels == frames[i].instance.pixels);
    RC_ASSERT(test::isSame(frame.cloud, frames[i].cloud));
  }
}

RC_GTEST_PROP(Recording, OfScansComesBackWithPosesAndClasses, ()) {
  requireRecordingsComeBack(Sensor::lidar);
}
RC_GTEST_PROP(Recording, OfImagesComesBackWithPosesAndClasses, ()) {
  requireRecordingsComeBack(Sensor::camera);
}

RC_GTEST_PROP(Likelihoods, ComeBackAsTheirText, ()) {
  search::LikelihoodTable table;
  for (auto& viewpoint : table.counts) {
    for (search::DistanceCounts& counts : viewpoint) {
      for (double& n : counts.at_true) n = *gen::inRange(0, 1 << 20);
      for (double& n : counts.at_wrong) n = *gen::inRange(0, 1 << 20);
    }
  }
  const search::LikelihoodTable read = search::parseLikelihoods(search::toText(table), "table");
  for (std::size_t v = 0; v < table.counts.size(); ++v) {
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      RC_ASSERT(read.counts[v][c].at_true == table.counts[v][c].at_true);
      RC_ASSERT(read.counts[v][c].at_wrong == table.counts[v][c].at_wrong);
    }
  }
}

RC_GTEST_PROP(Verdict, ModelComesBackToFourDigits, ()) {
  verdict::VerdictModel model;
  for (double& weight : model.registered.of) weight = *test::anyNumber(30);
  for (const verdict::Term t : {verdict::kConstant, verdict::kMargin})
    model.bare[t] = *test::anyNumber(30);
  test::writeText(scratch("verdict.txt"), verdict::toText(model));
  const verdict::VerdictModel read = verdict::readVerdictModel(scratch("verdict.txt"));
  RC_ASSERT(verdict::toText(read) == verdict::toText(model));
  for (std::size_t t = 0; t < verdict::kTerms; ++t) {
    const double was = model.registered.of[t];
    RC_ASSERT(std::abs(read.registered.of[t] - was) <= 1e-3 * std::abs(was));
  }
}

}  // namespace
}  // namespace xview::io
