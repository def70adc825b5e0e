// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>

#include "base/pose.h"
#include "io/image_decoding.h"
#include "io/layouts.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

constexpr double kFrameSeconds = 0.2;    ///< sequences are recorded at 5 Hz, without stamps
constexpr float kMetresPerUnit = 0.01f;  ///< depth is in centimetres

/// The sequence folder and the camera in it ("Stereo_Left/Omni_F").
struct SynthiaCamera {
  fs::path root;
  fs::path camera;
};

std::vector<double> numbersOfFile(const std::string& path) {
  InputFile file(path);
  std::vector<double> numbers;
  std::vector<std::string_view> words;
  while (file.readWords(words)) {
    for (const double number : file.numbersOf(words)) numbers.push_back(number);
  }
  return numbers;
}

bool hasImages(const fs::path& folder) {
  const auto is_png = [](const fs::directory_entry& e) { return e.path().extension() == ".png"; };
  return std::any_of(fs::directory_iterator(folder), fs::directory_iterator(), is_png);
}

/// The folder Depth above the folder of one camera; nothing if it is none.
std::optional<fs::path> depthFolderAbove(const std::string& folder) {
  for (fs::path above = fs::absolute(folder); above != above.root_path();
       above = above.parent_path()) {
    if (above.filename() == "Depth") return above;
  }
  return std::nullopt;
}

SynthiaCamera findCamera(const std::string& folder) {
  if (const auto above = depthFolderAbove(folder))
    return {above->parent_path(), fs::absolute(folder).lexically_relative(*above)};
  const fs::path root = folder, depth = root / "Depth";
  std::vector<fs::path> cameras;
  if (fs::is_directory(depth)) {
    for (const auto& entry : fs::recursive_directory_iterator(depth)) {
      if (entry.is_directory() && hasImages(entry)) {
        cameras.push_back(entry.path().lexically_relative(depth));
      }
    }
  }
  if (cameras.empty()) throw Error(depth.string(), "no camera folder with .png files");
  return {root, *std::min_element(cameras.begin(), cameras.end())};
}

/// intrinsics.txt: focal length, cx, cy, baseline. Those of all published sequences where the file
/// is missing.
Camera readIntrinsics(const fs::path& root) {
  Camera camera;
  camera.fx = 532.740352;
  camera.cx = 640;
  camera.cy = 380;
  camera.depth_scale = kMetresPerUnit;
  const std::string path = (root / "CameraParams" / "intrinsics.txt").string();
  if (fs::exists(path)) {
    const std::vector<double> numbers = numbersOfFile(path);
    if (numbers.size() < 3 || numbers[0] <= 0) {
      throw Error(
          path, fmt::format("expected focal length, cx and cy, found {} numbers", numbers.size()));
    }
    camera.fx = numbers[0];
    camera.cx = numbers[1];
    camera.cy = numbers[2];
  }
  camera.fy = camera.fx;
  return camera;
}

/// A 4x4 matrix column by column, camera to a left-handed world with y up. Swapping y and z makes
/// that world right-handed with z up. The axes of the camera are x right, y up, z backward or (in a
/// left-handed camera) forward.
Eigen::Isometry3d readPose(const std::string& path) {
  const std::vector<double> numbers = numbersOfFile(path);
  if (numbers.size() != 16) {
    throw Error(path, fmt::format("expected a 4x4 matrix, found {} numbers", numbers.size()));
  }
  Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(numbers.data());
  matrix.row(1).swap(matrix.row(2));
  matrix.col(1) = -matrix.col(1);
  if (matrix.topLeftCorner<3, 3>().determinant() < 0) matrix.col(2) = -matrix.col(2);
  if (!isRigid(matrix, 1e-3)) throw Error(path, "the 4x4 matrix is not a rigid transform");
  return poseOf(orthonormalized(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

DepthImage readCentimetres(const std::string& path) {
  const cv::Mat image = decodeImage(path, anySize(path));
  if (image.depth() != CV_16U) {
    throw Error(path, "expected 16-bit unsigned depth, found " + describePixels(image));
  }
  const LabelImage units = channelOf(image, 0, path);  // all channels are equal
  DepthImage depth(units.width, units.height);
  std::transform(units.pixels.begin(), units.pixels.end(), depth.pixels.begin(),
                 [](std::uint16_t unit) { return kMetresPerUnit * unit; });
  return depth;
}

}  // namespace

bool isSynthiaCamera(const std::string& folder) {
  const auto above = depthFolderAbove(folder);
  return above && fs::exists(above->parent_path() / "GT" / "LABELS");
}

RecordingListing listSynthia(const std::string& folder, const InputOptions& options) {
  const SynthiaCamera place = findCamera(folder);
  const Camera camera = readIntrinsics(place.root);
  RecordingListing listing;
  listing.frames = listFrames({"depth", (place.root / "Depth" / place.camera).string(), {".png"}});
  const fs::path labels = place.root / "GT" / "LABELS" / place.camera;
  addFiles(folder, {"label", labels.string(), {".png"}}, &ListedFrame::label, "depth",
           listing.frames);
  for (ListedFrame& frame : listing.frames) {
    const std::string name = fs::path(frame.measurement).stem().string() + ".txt";
    frame.stamp_s = kFrameSeconds * static_cast<double>(frame.number);
    frame.T_odom_sensor = readPose((place.root / "CameraParams" / place.camera / name).string());
  }
  listing.read = [camera](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readCentimetres(listed.measurement);
    frame.camera.width = frame.depth.width;
    frame.camera.height = frame.depth.height;
    const cv::Mat ids = decodeImage(listed.label, asLargeAsDepth(listed.label, listed, frame));
    frame.label = channelOf(ids, 2, listed.label);     // red: class
    frame.instance = channelOf(ids, 1, listed.label);  // green: instance
  };
  const auto named = namedLabels(options, place.root.string());
  listing.labels = named ? *named : shippedLabelSet("synthia");
  return listing;
}

}  // namespace xview::io
