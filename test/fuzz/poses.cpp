// SPDX-License-Identifier: BSD-3-Clause
// Poses of TUM and KITTI, and matrices. Poses that are read are written and read again.
#include "fuzz.h"
#include "xview/io/pose_files.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace xview;
  const std::string path =
      fuzz::written("in.txt", std::string(reinterpret_cast<const char*>(data), size));
  fuzz::isDone([&] {
    const std::vector<io::StampedPose> poses = io::readPoses(path);
    const std::string copy = fuzz::scratch() + "/out.txt";
    io::writeTumPoses(copy, poses);
    const std::vector<io::StampedPose> again = io::readPoses(copy);
    fuzz::require(again.size() == poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Isometry3d between = poses[i].T_frame_sensor.inverse() * again[i].T_frame_sensor;
      fuzz::require(between.linear().isIdentity(1e-6) && between.translation().norm() < 1e-3);
    }
  });
  fuzz::isDone([&] { io::posesOfFrames(path, {0, 2}); });
  fuzz::isDone([&] { io::readMatrix(path); });
  return 0;
}
