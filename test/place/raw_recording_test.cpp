// SPDX-License-Identifier: BSD-3-Clause
#include "place/raw_recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "base/random.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview {
namespace {

/// One cloud without a view-point, or one scan.
class OneCloud : public FrameSource {
 public:
  explicit OneCloud(pcl::PointCloud<Point> points, Sensor sensor = Sensor::cloud) {
    frame_.sensor = sensor;
    frame_.cloud.points = std::move(points);
  }
  std::size_t size() const override { return 1; }
  Eigen::Isometry3d pose(std::size_t) const override { return Eigen::Isometry3d::Identity(); }
  double stamp(std::size_t) const override { return 0; }
  std::int64_t number(std::size_t) const override { return 0; }
  Frame read(std::size_t) const override { return frame_; }
  Sensor sensor() const override { return frame_.sensor; }
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

std::vector<std::uint32_t> labelsOf(const pcl::PointCloud<Point>& points,
                                    Sensor sensor = Sensor::cloud) {
  const auto shapes =
      withShapeLabels(std::make_unique<OneCloud>(points, sensor), io::shippedLabelSet(kShapes), {});
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

/// Before shapes are looked for, which of a thousand times as much take minutes.
TEST(RawRecording, ACloudInMillimetresIsRefused) {
  pcl::PointCloud<Point> points = street();
  for (Point& p : points) p.getVector3fMap() *= 1000;
  try {
    labelsOf(points);
    FAIL() << "nothing was said";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("are their units millimetres"), std::string::npos);
  }
}

class ShapesOfScans : public testing::TestWithParam<Sensor> {};

/// Check fix for: scans of scanners that hang or lie on their sides had walls for ground, and those
/// that nobody knows to be scans wherever they did not lie by quarters.
TEST_P(ShapesOfScans, AreTheSameHoweverTheScannerStands) {
  pcl::PointCloud<Point> upright = street();
  for (Point& p : upright) p.getVector3fMap() -= Eigen::Vector3f(30, 5, 1.8F);
  const std::vector<std::uint32_t> expected = labelsOf(upright, GetParam());
  ASSERT_GT(std::count(expected.begin(), expected.end(), 1U), 7500) << "ground";
  ASSERT_GT(std::count(expected.begin(), expected.end(), 2U), 1000) << "walls";
  for (const Eigen::Vector3f& axis :
       {Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0.6F, 0.8F, 0)}) {
    for (const float degrees : {20.F, 30.F, 60.F, 90.F, -90.F, 110.F, 150.F, 180.F}) {
      pcl::PointCloud<Point> turned = upright;
      const Eigen::AngleAxisf turn(degrees * static_cast<float>(M_PI) / 180, axis);
      for (Point& p : turned) p.getVector3fMap() = turn * p.getVector3fMap();
      const std::vector<std::uint32_t> labels = labelsOf(turned, GetParam());
      std::size_t same = 0;
      for (std::size_t i = 0; i < labels.size(); ++i) same += labels[i] == expected[i];
      EXPECT_GT(same, labels.size() * 9 / 10) << degrees << " deg about " << axis.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(RawRecording, ShapesOfScans, testing::Values(Sensor::lidar, Sensor::cloud),
                         [](const auto& sensor) {
                           return std::string(sensor.param == Sensor::lidar ? "Lidar" : "Cloud");
                         });

/// Check fix for: between high walls, where a scanner of few beams sees nothing of the ground but
/// lines, one wall was taken for the floor and the other one for the ceiling.
TEST(RawRecording, AScanBetweenHighWallsIsNotTurned) {
  for (const Sensor sensor : {Sensor::lidar, Sensor::cloud}) {
    pcl::PointCloud<Point> points;
    Random random(5);
    const auto add = [&](double x, double y, double z) {
      points.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0);
    };
    for (const double radius_m : {6.0, 8.0, 11.0, 16.0}) {
      for (int i = 0; i < 400; ++i) {
        const double turn = 2 * M_PI * i / 400;
        if (std::abs(radius_m * std::sin(turn)) < 4)
          add(radius_m * std::cos(turn), radius_m * std::sin(turn), -1.6 + 0.02 * random.normal());
      }
    }
    const std::size_t ground = points.size();
    for (int i = 0; i < 6000; ++i)
      add(40 * random.uniform() - 20, (i % 2 == 0 ? 4 : -4) + 0.02 * random.normal(),
          8 * random.uniform() - 1.6);
    const std::vector<std::uint32_t> labels = labelsOf(points, sensor);
    std::size_t walls = 0;
    for (std::size_t i = ground; i < labels.size(); ++i) walls += labels[i] == 2U;
    EXPECT_GT(walls, 4500U);
    EXPECT_GT(std::count(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(ground), 1U),
              static_cast<std::ptrdiff_t>(ground * 9 / 10));
  }
}

/// A street that climbs stays as it is.
TEST(RawRecording, AScanOfASteepStreetIsNotTurned) {
  pcl::PointCloud<Point> steep = street();
  for (Point& p : steep) {
    p.getVector3fMap() -= Eigen::Vector3f(30, 5, 1.8F);
    p.z += 0.1F * p.x;
  }
  const std::vector<std::uint32_t> labels = labelsOf(steep, Sensor::lidar);
  EXPECT_GT(std::count(labels.begin(), labels.end(), 1U), 7500);
}

}  // namespace
}  // namespace xview
