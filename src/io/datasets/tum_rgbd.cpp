// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "base/pose.h"
#include "io/image_decoding.h"
#include "io/image_files.h"
#include "io/layouts.h"
#include "xview/base/error.h"
#include "xview/io/pose_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime = 0.02;   ///< a depth and a colour image this near are one frame [s]
constexpr double kLongestGap = 0.2;  ///< between poses that are still interpolated [s]

/// Kinect of the published sequences, unless camera.yaml says otherwise.
Camera cameraOf(const fs::path& folder) {
  const fs::path path = folder / "camera.yaml";
  if (fs::exists(path)) return readCamera(path.string());
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.depth_scale = 1.0 / 5000;
  return camera;
}

/// The label image of a depth image: of its own name, or of the name of the colour image of that
/// time.
class LabelFinder {
 public:
  explicit LabelFinder(const fs::path& folder) : folder_(folder / "label") {
    if (fs::exists(folder / "rgb.txt")) colors_ = readFileList((folder / "rgb.txt").string());
  }
  std::string find(const StampedFile& depth) const {
    const std::string own = labelNamed(depth.path);
    if (!own.empty()) return own;
    const StampedFile* nearest = nearestTo(depth.stamp_s, colors_, kSameTime);
    return nearest ? labelNamed(nearest->path) : "";
  }

 private:
  std::string labelNamed(const std::string& file) const {
    const fs::path path = folder_ / (fs::path(file).stem().string() + ".png");
    return fs::exists(path) ? path.string() : "";
  }

  fs::path folder_;
  std::vector<StampedFile> colors_;
};

/// Empty if nothing is.
std::string whatIsLeftOut(std::size_t depths, std::size_t with_label, std::size_t used) {
  if (used == depths) return {};
  std::string text = fmt::format("{} of {} depth images are left out", depths - used, depths);
  if (depths > with_label)
    text += fmt::format(
        "; {} have no label image (label/ of their own name, or of the colour image within 0.02 s "
        "of rgb.txt)",
        depths - with_label);
  if (with_label > used)
    text += fmt::format(
        "; {} have no pose within 0.2 s; do the stamps of depth.txt and groundtruth.txt have all "
        "their digits?",
        with_label - used);
  return text;
}

}  // namespace

std::vector<StampedFile> readFileList(const std::string& path) {
  InputFile input(path);
  std::vector<StampedFile> files;
  std::vector<std::string_view> words;
  std::string_view line;
  while (input.readWords(words, "#", &line)) {
    if (words.size() != 2) input.failAtLine("expected stamp and file, found {}", inQuotes(line));
    input.requireFileName(words[1]);
    files.push_back({input.numbersOf({words[0]})[0], fs::path(path).parent_path() / words[1]});
  }
  return files;
}

const StampedFile* nearestTo(double stamp_s, const std::vector<StampedFile>& files,
                             double within_s) {
  const StampedFile* nearest = nullptr;
  for (const StampedFile& file : files) {
    const double gap = std::abs(file.stamp_s - stamp_s);
    if (gap <= within_s && (!nearest || gap < std::abs(nearest->stamp_s - stamp_s)))
      nearest = &file;
  }
  return nearest;
}

RecordingListing listTumRgbd(const std::string& folder, const InputOptions& options) {
  const fs::path root(folder);
  const std::string list_path = (root / "depth.txt").string();
  const std::vector<StampedFile> depths = readFileList(list_path);
  std::vector<StampedPose> poses = readPoses((root / "groundtruth.txt").string());
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_s < b.stamp_s;
  });
  const LabelFinder labels(root);
  const bool is_raw = !fs::exists(root / "label");

  RecordingListing listing;
  std::size_t with_label = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const std::string label = labels.find(depths[i]);
    if (label.empty() && !is_raw) continue;
    ++with_label;
    const auto pose = poseAt(poses, depths[i].stamp_s, kLongestGap);
    if (!pose) continue;
    listing.frames.push_back(
        {static_cast<std::int64_t>(i), depths[i].stamp_s, *pose, depths[i].path, label, ""});
  }
  const std::string left_out = whatIsLeftOut(depths.size(), with_label, listing.frames.size());
  if (listing.frames.empty()) throw Error(list_path, "no usable frame: " + left_out);
  if (!left_out.empty()) listing.notes.push_back(left_out);
  listing.read = [camera = cameraOf(root)](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readDepth(listed.measurement, camera);
    if (listed.label.empty()) return;
    frame.label = readLabels(listed.label, asLargeAsDepth(listed.label, listed, frame));
  };
  if (!is_raw) nameClasses(listing, options, folder);
  return listing;
}

}  // namespace xview::io
