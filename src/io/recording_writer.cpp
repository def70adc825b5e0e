// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <fmt/core.h>

#include <atomic>
#include <filesystem>
#include <utility>

#include "xview/io/atomic_file.h"
#include "xview/io/image_files.h"
#include "xview/io/pose_files.h"

#include "xview/types/parallel.h"

namespace xview::io {
namespace {

std::string numbered(const std::string& folder, std::int64_t number, const char* ending) {
  return fmt::format("{}/{:06d}.{}", folder, number, ending);
}

/// Frames of an earlier, longer recording would be taken for frames of this one.
void removeFramesFrom(std::size_t first, const std::string& folder, const char* ending) {
  for (auto number = static_cast<std::int64_t>(first);; ++number) {
    std::error_code problem;
    if (!std::filesystem::remove(numbered(folder, number, ending), problem)) return;
  }
}

std::string classesYaml(const LabelSet& labels) {
  std::string text = labels.name().empty() ? "" : fmt::format("name: \"{}\"\n", labels.name());
  text += "classes:\n";
  for (const auto& [id, info] : labels.classes()) {
    text += fmt::format("  - {{id: {}, name: \"{}\", color: [{}, {}, {}], role: {}, kind: {}}}\n",
                        id, info.name, info.color[0], info.color[1], info.color[2],
                        toString(info.role), toString(info.kind));
  }
  return text;
}

void writeCameraFrame(const std::string& folder, const Frame& frame) {
  writeDepthPng(numbered(folder + "/depth", frame.number, "png"), frame.depth,
                frame.camera.depth_scale);
  writeLabelPng(numbered(folder + "/label", frame.number, "png"), frame.label);
  if (!frame.instance.empty()) {
    writeLabelPng(numbered(folder + "/instance", frame.number, "png"), frame.instance);
  }
}

void writeScan(const std::string& folder, const Frame& frame) {
  const LabelledCloud& cloud = frame.cloud;
  std::vector<float> points;
  std::vector<std::uint32_t> labels;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i).cast<float>();
    points.insert(points.end(), {p.x(), p.y(), p.z(), 0.0f});  // the simulator knows no intensity
    const std::uint32_t instance = cloud.points[i].instance & 0xFFFFu;
    labels.push_back((cloud.points[i].label & 0xFFFFu) | instance << 16);
  }
  writeFile(numbered(folder + "/velodyne", frame.number, "bin"), points);
  writeFile(numbered(folder + "/labels", frame.number, "label"), labels);
}

/// KITTI poses are those of a camera; a calibration of identity says that camera and scanner are
/// one.
void writeKittiPoses(const std::string& folder, const FrameSource& source) {
  std::string poses, times;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Matrix4d T = source.pose(i).matrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) poses += fmt::format("{} ", T(row, column));
    }
    poses.back() = '\n';
    times += fmt::format("{}\n", source.stamp(i));
  }
  writeFile(folder + "/poses.txt", poses);
  writeFile(folder + "/times.txt", times);
  writeFile(folder + "/calib.txt", std::string("Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n"));
}

std::vector<StampedPose> stamped(const FrameSource& source,
                                 const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<StampedPose> result;
  for (std::size_t i = 0; i < poses.size(); ++i) result.push_back({source.stamp(i), poses[i]});
  return result;
}

void writeSidecars(const std::string& folder, const FrameSource& source) {
  writeFile(folder + "/classes.yaml", classesYaml(source.labels()));
  if (source.sensor() != Sensor::camera) return writeKittiPoses(folder, source);
  writeCamera(folder + "/camera.yaml", source.read(0).camera);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < source.size(); ++i) poses.push_back(source.pose(i));
  writeTumPoses(folder + "/poses.txt", stamped(source, poses));
}

void writeParts(const std::string& folder, const FrameSource& source,
                const std::vector<Eigen::Isometry3d>& truth, int threads,
                const std::function<void(std::size_t, std::size_t)>& progress) {
  const bool camera = source.sensor() == Sensor::camera;
  using Parts = std::vector<std::pair<const char*, const char*>>;  // folder and ending
  const Parts parts = camera ? Parts{{"depth", "png"}, {"label", "png"}, {"instance", "png"}}
                             : Parts{{"velodyne", "bin"}, {"labels", "label"}};
  for (const auto& [part, ending] : parts) {
    if (part == std::string("instance") && source.read(0).instance.empty()) continue;
    makeFolder(folder + "/" + part);
    removeFramesFrom(source.size(), folder + "/" + part, ending);
  }
  writeSidecars(folder, source);
  if (!truth.empty()) writeTumPoses(folder + "/groundtruth.txt", stamped(source, truth));
  std::atomic<std::size_t> done{0};
  parallelFor(source.size(), threads, [&](std::size_t i) {
    const Frame frame = source.read(i);
    if (camera)
      writeCameraFrame(folder, frame);
    else
      writeScan(folder, frame);
    const std::size_t now = ++done;
    if (progress) progress(now, source.size());
  });
}

}  // namespace

void writeRecording(const std::string& folder, const FrameSource& source,
                    const std::vector<Eigen::Isometry3d>& truth, int threads,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  std::error_code problem;
  const std::filesystem::path parent = std::filesystem::path(folder).parent_path();
  const bool is_new = !std::filesystem::exists(folder, problem),
             parent_is_new = !std::filesystem::exists(parent, problem);
  try {
    writeParts(folder, source, truth, threads, progress);
  } catch (...) {
    if (is_new) std::filesystem::remove_all(folder, problem);
    if (parent_is_new) std::filesystem::remove(parent, problem);  // unless something else is there
    throw;
  }
}

}  // namespace xview::io
