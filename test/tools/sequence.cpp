// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sequence.h"

#include <cstdio>
#include <filesystem>

#include "io/image_files.h"
#include "support/program.h"
#include "support/test_data.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

constexpr int kRoad = 3, kWall = 2, kPole = 7;

Camera camera() {
  Camera c;
  c.width = 64;
  c.height = 48;
  c.fx = c.fy = 40;
  c.cx = 31.5;
  c.cy = 23.5;
  c.depth_scale = 0.01;
  return c;
}

struct Hit {
  float depth = 0;
  std::uint16_t label = 0;
};

/// What the ray (x, y, 1) of a camera 1.5 m above the road and `ahead` metres along it meets first.
Hit cast(double x, double y, double ahead) {
  Hit hit{static_cast<float>(20 - ahead), kWall};
  if (y > 0 && 1.5 / y < hit.depth) hit = {static_cast<float>(1.5 / y), kRoad};
  const double poles[3][2] = {{-2, 6}, {1, 8}, {3, 12}};
  for (const auto& pole : poles) {
    const double depth = pole[1] - ahead;
    if (depth > 0 && depth < hit.depth && std::abs(x * depth - pole[0]) < 0.25)
      hit = {static_cast<float>(depth), kPole};
  }
  return hit;
}

std::string numbered(const std::string& folder, int number) {
  char name[16];
  std::snprintf(name, sizeof name, "/%06d.png", number);
  return folder + name;
}

}  // namespace

void writeSequence(const std::string& folder, int frames) {
  std::filesystem::create_directories(folder + "/depth");
  std::filesystem::create_directories(folder + "/label");
  const Camera c = camera();
  io::writeCamera(folder + "/camera.yaml", c);
  writeText(folder + "/classes.yaml",
            "- {id: 0, name: void}\n- {id: 2, name: building}\n- {id: 3, name: road}\n- {id: 7, "
            "name: pole}\n");
  std::vector<io::StampedPose> poses;
  for (int i = 0; i < frames; ++i) {
    DepthImage depth(c.width, c.height);
    LabelImage label(c.width, c.height);
    for (int v = 0; v < c.height; ++v) {
      for (int u = 0; u < c.width; ++u) {
        const Hit hit = cast((u - c.cx) / c.fx, (v - c.cy) / c.fy, 0.5 * i);
        depth.at(u, v) = hit.depth;
        label.at(u, v) = hit.label;
      }
    }
    io::writeDepthPng(numbered(folder + "/depth", i), depth, c.depth_scale);
    io::writeLabelPng(numbered(folder + "/label", i), label);
    io::StampedPose pose;
    pose.stamp_s = 0.1 * i;
    // optical axes (x right, y down, z forward) in an odometry frame with x forward and z up
    pose.T_frame_sensor.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    pose.T_frame_sensor.translation() = Eigen::Vector3d(0.5 * i, 0, 1.5);
    poses.push_back(pose);
  }
  io::writeTumPoses(folder + "/poses.txt", poses);
}

}  // namespace xview::test
