// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include "layouts.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/types/error.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

/// Tr of calib.txt: velodyne to camera 0.
Eigen::Isometry3d readVelodyneToCamera(const std::string& path) {
  InputFile file(path);
  std::vector<std::string_view> words;
  while (file.readWords(words)) {
    if (words[0] != "Tr:" && words[0] != "Tr") continue;
    words.erase(words.begin());
    const std::vector<double> numbers = file.numbersOf(words);
    if (numbers.size() != 12) {
      file.failAtLine("Tr: expected 12 numbers, found {}", numbers.size());
    }
    return poseFromRows(numbers.data(), file);
  }
  throw Error(path, "no line `Tr: ` with 12 numbers, velodyne to camera 0");
}

/// One time in seconds per line.
std::vector<double> readTimes(const std::string& path) {
  InputFile file(path);
  std::vector<double> times;
  std::vector<std::string_view> words;
  std::string_view line;
  while (file.readWords(words, "", &line)) {
    if (words.size() != 1) file.failAtLine("expected one number, found {}", quoted(line));
    times.push_back(file.numbersOf(words)[0]);
  }
  return times;
}

/// T_odom_velo = Tr^-1 T_cam Tr, so that the odometry frame is that of the velodyne where the poses
/// are identity.
void setVelodynePoses(const fs::path& root, std::vector<ListedFrame>& frames) {
  const fs::path poses_path = root / "poses.txt";
  if (frames.size() == 1 && !fs::exists(poses_path)) return;
  setPoses(poses_path.string(), frames);
  const Eigen::Isometry3d T_cam_velo = readVelodyneToCamera((root / "calib.txt").string());
  for (ListedFrame& frame : frames) {
    frame.T_odom_sensor = T_cam_velo.inverse() * frame.T_odom_sensor * T_cam_velo;
  }
  const std::string times_path = (root / "times.txt").string();
  if (!fs::exists(times_path)) return;
  const std::vector<double> times = readTimes(times_path);
  const auto lines = linesOfFrames(times_path, "times", times.size(), numbersOf(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].stamp_s = times[lines[i]];
}

/// The labels of a single scan: beside it, or in the folder of a sequence; empty if it has none.
std::string labelFileOf(const fs::path& scan) {
  const fs::path beside = fs::path(scan).replace_extension(".label");
  if (fs::exists(beside)) return beside.string();
  const fs::path folder = fs::absolute(scan).parent_path().parent_path() / "labels";
  const fs::path in_sequence = folder / (scan.stem().string() + ".label");
  return fs::exists(in_sequence) ? in_sequence.string() : std::string();
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
    const fs::path root(path);
    listing.frames = listFrames({".bin", (root / "velodyne").string(), {".bin"}});
    if (fs::exists(root / "labels")) {
      addFiles(path, {".label", (root / "labels").string(), {".label"}}, &ListedFrame::label,
               ".bin", listing.frames);
    }
    setVelodynePoses(root, listing.frames);
  } else {
    listing.frames.resize(1);
    listing.frames[0].number = frameNumberOf(path);
    listing.frames[0].measurement = path;
    listing.frames[0].label = labelFileOf(path);
  }
  if (listing.frames.front().label.empty()) return listing;  // raw
  if (const auto named = namedLabels(options, folderOfClasses(path)))
    listing.labels = *named;
  else
    guessSemanticKittiLabels(listing, options);
  return listing;
}

}  // namespace xview::io
