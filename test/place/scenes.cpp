// SPDX-License-Identifier: BSD-3-Clause
#include "scenes.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"

namespace xview::test {

LabelSet townLabels() {
  return labelSetOf("town", {{kVoid, "void", Role::ignored, Kind::none},
                             {kSky, "sky", Role::ignored, Kind::none},
                             {kRoad, "road", Role::surface, Kind::road},
                             {kBuilding, "building", Role::surface, Kind::building},
                             {kPole, "pole", Role::object, Kind::pole},
                             {kCar, "car", Role::dynamic, Kind::vehicle},
                             {kBench, "bench", Role::object, Kind::other_object}});
}

LabelledCloud cloudOf(const std::vector<Eigen::Vector3f>& points, std::uint32_t label,
                      const Eigen::Vector3d& origin) {
  LabelledCloud cloud;
  cloud.origin = origin;
  for (const Eigen::Vector3f& p : points) {
    cloud.points.push_back(Point(p.x(), p.y(), p.z(), label));
  }
  return cloud;
}

std::vector<Eigen::Vector3f> clumpedPoints(std::size_t count, double extent_m, Random& random) {
  std::vector<Eigen::Vector3f> points;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double spread = 1;
  while (points.size() < count) {
    if (random.uniform() < 0.02) {
      for (int axis = 0; axis < 3; ++axis) centre[axis] = random.uniform(-extent_m, extent_m);
      spread = random.uniform(0.05, 0.2 * extent_m);
    }
    const Eigen::Vector3d offset(random.normal(), random.normal(), random.normal());
    points.push_back((centre + spread * offset).cast<float>());
  }
  return points;
}

Blob blobAt(std::uint32_t label, double x, double y, double z, std::uint32_t points) {
  Blob blob;
  blob.label = label;
  blob.position = blob.min = blob.max = Eigen::Vector3d(x, y, z);
  blob.points = points;
  return blob;
}

MergeOptions mergeOptions(const std::string& mode) {
  MergeOptions options;
  options.mode = mode;
  options.min_surface_points = 1;
  return options;
}

std::vector<Vertex> merged(const MergeOptions& options,
                           const std::vector<std::vector<Blob>>& frames) {
  PlaceGraphBuilder builder(townLabels(), options);
  for (std::size_t i = 0; i < frames.size(); ++i)
    builder.add(frames[i], static_cast<std::int64_t>(i));
  const SemanticGraph graph = builder.graph();
  EXPECT_TRUE(isConsistent(graph));
  return graph.vertices;
}

Frame flatFrame(int width, int height, std::uint16_t label, float depth_m) {
  Frame frame;
  frame.camera.width = width;
  frame.camera.height = height;
  frame.camera.fx = frame.camera.fy = width / 2.0;
  frame.camera.cx = (width - 1) / 2.0;
  frame.camera.cy = (height - 1) / 2.0;
  frame.depth = DepthImage(width, height, depth_m);
  frame.label = LabelImage(width, height, label);
  return frame;
}

Eigen::Isometry3d randomPose(Random& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  T.linear() = Eigen::AngleAxisd(random.uniform(0, 3), axis.normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(random.uniform(-1e3, 1e3), random.uniform(-1e3, 1e3),
                                    random.uniform(-50, 50));
  return T;
}

}  // namespace xview::test
