// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>

#include "io/image_decoding.h"
#include "io/image_files.h"
#include "io/layouts.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

constexpr float kFarthest = 655.35f;  ///< the largest value of the depth images: sky [m]
constexpr double kFramePeriod_s = 0.1;

/// The shipped classes with the colours of colors.txt, "Category r g b" and one line per category.
LabelSet readClassColors(const std::string& path) {
  const LabelSet shipped = shippedLabelSet("virtual_kitti");
  InputFile file(path);
  LabelSet labels(shipped.name());
  std::vector<std::string_view> words;
  std::string_view line;
  while (file.readWords(words, "", &line)) {
    if (words[0] == "Category") continue;
    if (words.size() != 4) file.failAtLine("expected category and r g b, found {}", inQuotes(line));
    const std::vector<double> rgb = file.numbersOf({words[1], words[2], words[3]});
    const auto known =
        std::find_if(shipped.classes().begin(), shipped.classes().end(),
                     [&](const auto& entry) { return entry.second.name == words[0]; });
    if (known == shipped.classes().end()) file.failAtLine("unknown category " + inQuotes(words[0]));
    ClassInfo info = known->second;
    for (std::size_t c = 0; c < 3; ++c) {
      if (rgb[c] < 0 || rgb[c] > 255) file.failAtLine("expected colours in [0, 255]");
      info.color[c] = static_cast<std::uint8_t>(rgb[c]);
    }
    labels.add(info);
  }
  if (labels.empty()) file.fail("no categories");
  return labels;
}

/// One row of a table with "frame cameraID …" of camera 0.
struct TableRow {
  std::int64_t frame = 0;
  std::vector<double> values;
};

std::vector<TableRow> readRows(InputFile& file, std::size_t columns) {
  std::vector<TableRow> rows;
  std::vector<std::string_view> words;
  while (file.readWords(words)) {
    if (words[0] == "frame") continue;
    const std::vector<double> numbers = file.numbersOf(words);
    if (numbers.size() != columns + 2) {
      file.failAtLine("expected {} numbers, found {}", columns + 2, numbers.size());
    }
    if (numbers[1] != 0) continue;
    const auto frame = static_cast<std::int64_t>(numbers[0]);
    rows.push_back({frame, {numbers.begin() + 2, numbers.end()}});
  }
  return rows;
}

/// The camera does not change within a sequence; the first row counts.
Camera readIntrinsics(const std::string& path) {
  InputFile file(path);
  const std::vector<TableRow> rows = readRows(file, 4);
  if (rows.empty()) file.fail("no row of camera 0");
  Camera camera;
  camera.fx = rows[0].values[0];
  camera.fy = rows[0].values[1];
  camera.cx = rows[0].values[2];
  camera.cy = rows[0].values[3];
  camera.depth_scale = 0.01;
  if (camera.fx <= 0 || camera.fy <= 0) file.fail("focal lengths must be above 0");
  return camera;
}

/// T_camera_world by frame, turned into the pose of the camera in a world with z up (theirs has y
/// down).
std::map<std::int64_t, Eigen::Isometry3d> readExtrinsics(const std::string& path) {
  InputFile file(path);
  Eigen::Isometry3d T_up_world = Eigen::Isometry3d::Identity();
  T_up_world.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  std::map<std::int64_t, Eigen::Isometry3d> poses;
  for (const TableRow& row : readRows(file, 16)) {
    poses[row.frame] = T_up_world * poseFromRows(row.values.data(), file).inverse();
  }
  return poses;
}

void readImages(Camera camera, const ColorTable& colors, const ListedFrame& listed, Frame& frame) {
  const cv::Mat labels = decodeImage(listed.label, anySize(listed.label));
  camera.width = labels.cols;
  camera.height = labels.rows;
  frame.camera = camera;
  frame.label = labelsOfColors(labels, colors, listed.label);
  frame.depth = readDepth(listed.measurement, camera);
  for (float& depth : frame.depth.pixels) {
    if (depth >= kFarthest) depth = 0;
  }
}

}  // namespace

RecordingListing listVirtualKitti(const std::string& folder, const InputOptions& options) {
  const fs::path root(folder), frames = root / "frames";
  RecordingListing listing;
  listing.frames = listFrames({"depth", (frames / "depth" / "Camera_0").string(), {".png"}});
  const auto labels =
      listFrames({"label", (frames / "classSegmentation" / "Camera_0").string(), {".png"}});
  if (numbersOf(listing.frames) != numbersOf(labels)) {
    throw Error(folder, std::to_string(listing.frames.size()) + " depth files but " +
                            std::to_string(labels.size()) + " label files, or of other frames");
  }
  const std::string poses_path = (root / "extrinsic.txt").string();
  const auto poses = readExtrinsics(poses_path);
  const std::string colors_path = (root / "colors.txt").string();
  const LabelSet colors =
      fs::exists(colors_path) ? readClassColors(colors_path) : shippedLabelSet("virtual_kitti");
  for (std::size_t i = 0; i < labels.size(); ++i) {
    ListedFrame& frame = listing.frames[i];
    const auto pose = poses.find(frame.number);
    if (pose == poses.end()) {
      throw Error(poses_path, "no row for frame " + std::to_string(frame.number) + " of camera 0");
    }
    frame.stamp_s = kFramePeriod_s * static_cast<double>(frame.number);
    frame.T_odom_sensor = pose->second;
    frame.label = labels[i].measurement;
  }
  listing.read = [camera = readIntrinsics((root / "intrinsic.txt").string()),
                  table = colorTable(colors)](const ListedFrame& listed, Frame& frame) {
    readImages(camera, table, listed, frame);
  };
  const auto named = namedLabels(options, folder);
  listing.labels = named ? *named : colors;
  return listing;
}

}  // namespace xview::io
