// SPDX-License-Identifier: BSD-3-Clause
#include "xview/raw_recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "xview/io/label_files.h"
#include "xview/types/random.h"

namespace xview {
namespace {

/// One cloud without a view-point.
class OneCloud : public FrameSource {
 public:
  explicit OneCloud(pcl::PointCloud<Point> points) {
    frame_.sensor = Sensor::cloud;
    frame_.cloud.points = std::move(points);
  }
  std::size_t size() const override { return 1; }
  Eigen::Isometry3d pose(std::size_t) const override { return Eigen::Isometry3d::Identity(); }
  double stamp(std::size_t) const override { return 0; }
  std::int64_t number(std::size_t) const override { return 0; }
  Frame read(std::size_t) const override { return frame_; }
  Sensor sensor() const override { return Sensor::cloud; }
  const LabelSet& labels() const override { return labels_; }
  const std::string& name() const override { return name_; }

 private:
  Frame frame_;
  LabelSet labels_;
  std::string name_ = "cloud";
};

/// A street: 60 x 10 m of ground between two walls of 6 m.
pcl::PointCloud<Point> street() {
  pcl::PointCloud<Point> points;
  Random random(3);
  const auto add = [&](double x, double y, double z) {
    points.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0);
  };
  for (int i = 0; i < 8000; ++i) {
    add(60 * random.uniform(), 10 * random.uniform(), 0.02 * random.normal());
    if (i % 10 > 2) continue;
    add(60 * random.uniform(), 10 * (i % 2) + 0.02 * random.normal(), 6 * random.uniform());
  }
  return points;
}

std::vector<std::uint32_t> labelsOf(const pcl::PointCloud<Point>& points) {
  const auto shapes =
      withShapeLabels(std::make_unique<OneCloud>(points), io::shippedLabelSet(kShapes), {});
  std::vector<std::uint32_t> labels;
  for (const Point& point : shapes->read(0).cloud.points) labels.push_back(point.label);
  return labels;
}

/// Meshes are drawn with y up, and cameras have y down.
TEST(RawRecording, ACloudWithYUpOrDownHasTheShapesOfOneWithZUp) {
  const pcl::PointCloud<Point> upright = street();
  const std::vector<std::uint32_t> expected = labelsOf(upright);
  EXPECT_GT(std::count(expected.begin(), expected.end(), 1U), 7500) << "ground";
  EXPECT_GT(std::count(expected.begin(), expected.end(), 2U), 1000) << "walls";
  for (const float up : {1.F, -1.F}) {
    pcl::PointCloud<Point> turned = upright;
    for (Point& p : turned) p.getVector3fMap() = Eigen::Vector3f(up * p.x, up * p.z, -p.y);
    const std::vector<std::uint32_t> labels = labelsOf(turned);
    EXPECT_GT(std::count(labels.begin(), labels.end(), 1U), 7500) << "ground, y " << up;
    EXPECT_GT(std::count(labels.begin(), labels.end(), 2U), 1000) << "walls, y " << up;
  }
}

}  // namespace
}  // namespace xview
