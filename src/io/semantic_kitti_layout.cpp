// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include "frame_listing.h"
#include "header_text.h"
#include "label_choice.h"
#include "pose_lines.h"
#include "recording_layouts.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"
#include "xview/types/error.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

/// Scans are looked at in this many frames to tell the id space; every scan has thousands of
/// labels.
constexpr std::size_t kScansToLookAt = 8;

/// Tr of calib.txt: velodyne to camera 0.
Eigen::Isometry3d readVelodyneToCamera(const std::string& path) {
  InputFile file(path);
  std::string_view line;
  while (file.readLine(line)) {
    std::vector<std::string_view> words = splitWords(line);
    if (words.empty() || (words[0] != "Tr:" && words[0] != "Tr")) continue;
    words.erase(words.begin());
    const std::vector<double> numbers = numbersOf(words, file);
    if (numbers.size() != 12) {
      file.failAtLine("Tr: expected 12 numbers, found " + std::to_string(numbers.size()));
    }
    return poseFromRows(numbers.data(), file);
  }
  throw Error(path, "no line `Tr: ` with 12 numbers, velodyne to camera 0");
}

/// One time in seconds per line.
std::vector<double> readTimes(const std::string& path) {
  InputFile file(path);
  std::vector<double> times;
  std::string_view line;
  while (file.readLine(line)) {
    const std::vector<std::string_view> words = splitWords(line);
    if (words.empty()) continue;
    if (words.size() != 1) file.failAtLine("expected one number, found " + quoted(line));
    times.push_back(numbersOf(words, file)[0]);
  }
  return times;
}

/// T_odom_velo = Tr^-1 T_cam Tr, so that the odometry frame is that of the velodyne where the poses
/// are identity.
void setPoses(const fs::path& root, std::vector<ListedFrame>& frames) {
  const fs::path poses_path = root / "poses.txt";
  if (frames.size() == 1 && !fs::exists(poses_path)) return;
  std::vector<std::int64_t> numbers;
  for (const ListedFrame& frame : frames) numbers.push_back(frame.number);
  const std::vector<StampedPose> poses = posesOfFrames(poses_path.string(), numbers);
  const Eigen::Isometry3d T_cam_velo = readVelodyneToCamera((root / "calib.txt").string());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].stamp_s = poses[i].stamp_s;
    frames[i].T_odom_sensor = T_cam_velo.inverse() * poses[i].T_frame_sensor * T_cam_velo;
  }
  const std::string times_path = (root / "times.txt").string();
  if (!fs::exists(times_path)) return;
  const std::vector<double> times = readTimes(times_path);
  const auto lines = linesOfFrames(times_path, "times", times.size(), numbers);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].stamp_s = times[lines[i]];
}

/// The labels of a single scan: beside it, or in the folder of a sequence.
std::string labelFileOf(const fs::path& scan) {
  const fs::path beside = fs::path(scan).replace_extension(".label");
  if (fs::exists(beside)) return beside.string();
  const fs::path folder = fs::absolute(scan).parent_path().parent_path() / "labels";
  const fs::path in_sequence = folder / (scan.stem().string() + ".label");
  if (fs::exists(in_sequence)) return in_sequence.string();
  throw Error(scan.string(),
              "no labels: neither " + beside.string() + " nor " + in_sequence.string());
}

std::vector<ListedFrame> listScans(const std::string& folder) {
  const fs::path root(folder);
  const auto scans = listFiles((root / "velodyne").string(), {".bin"});
  const auto labels = listFiles((root / "labels").string(), {".label"});
  requireSameFrames(folder, ".bin", scans, ".label", labels);
  const std::vector<std::int64_t> numbers = frameNumbers(scans);
  std::vector<ListedFrame> frames(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    frames[i].number = numbers[i];
    frames[i].measurement = scans[i].path;
    frames[i].label = labels[i].path;
  }
  setPoses(root, frames);
  return frames;
}

/// classes.yaml may lie beside a single scan or in the folder of its sequence.
std::string folderOfClasses(const fs::path& path) {
  if (fs::is_directory(path)) return path.string();
  const fs::path folder = fs::absolute(path).parent_path();
  const bool in_sequence = folder.filename() == "velodyne" && !fs::exists(folder / "classes.yaml");
  return (in_sequence ? folder.parent_path() : folder).string();
}

}  // namespace

RecordingListing listSemanticKitti(const std::string& path, const InputOptions& options) {
  RecordingListing listing;
  listing.sensor = Sensor::lidar;
  listing.read = [](const ListedFrame& listed, Frame& frame) {
    frame.cloud = readKittiScan(listed.measurement, listed.label);
  };
  if (fs::is_directory(path)) {
    listing.frames = listScans(path);
  } else {
    ListedFrame frame;
    frame.number = frameNumbers({{fs::path(path).stem().string(), path}})[0];
    frame.measurement = path;
    frame.label = labelFileOf(path);
    listing.frames = {frame};
  }
  const auto named = namedLabels(options.labels, folderOfClasses(path));
  listing.labels =
      named ? *named : semanticKittiLabels(countLabels(listing, kScansToLookAt), options);
  return listing;
}

}  // namespace xview
