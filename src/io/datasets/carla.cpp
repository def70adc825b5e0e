// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include "datasets.h"
#include "io/frame_listing.h"
#include "io/image_decoding.h"
#include "io/label_choice.h"
#include "xview/io/image_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"
#include "xview/types/error.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

constexpr double kFarthest = 1000;  ///< the depth camera ends here [m]
constexpr std::size_t kFramesToLookAt = 16;

/// Raw depth camera: 24 bits in red (lowest), green and blue, as a share of the farthest distance.
DepthImage readCodedDepth(const std::string& path) {
  const cv::Mat image = decodeImage(path);
  if (image.depth() != CV_8U || image.channels() < 3) {
    throw Error(path, "expected depth coded in 8-bit colours, found " + describePixels(image));
  }
  const int channels = image.channels();
  DepthImage depth(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* pixel = image.ptr<std::uint8_t>(y);  // blue, green, red
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      const int code = pixel[2] + 256 * pixel[1] + 65536 * pixel[0];
      // All ones is the sky.
      depth.at(x, y) = code == 0xFFFFFF ? 0 : static_cast<float>(kFarthest * code / 0xFFFFFF);
    }
  }
  return depth;
}

void readImages(const Camera& camera, const ListedFrame& listed, Frame& frame) {
  frame.camera = camera;
  frame.depth = readCodedDepth(listed.measurement);
  requireSameSize(listed.measurement, frame.depth.width, frame.depth.height, "camera.yaml",
                  camera.width, camera.height);
  const cv::Mat tags = decodeImage(listed.label);
  frame.label = channelOf(tags, tags.channels() == 1 ? 0 : 2, listed.label);  // red: the tag
  requireSameSize(listed.label, frame.label.width, frame.label.height, listed.measurement,
                  frame.depth.width, frame.depth.height);
}

/// The tags were renumbered in 0.9.14: road was 7 (now traffic light), and is 1 (was building).
LabelSet carlaLabels(const LabelCounts& counts) {
  const auto share_of = [&](std::uint32_t id) {
    const auto found = counts.find(id);
    return found == counts.end() ? 0 : found->second;
  };
  std::uint64_t all = 0, beyond_old = 0;
  for (const auto& [id, pixels] : counts) {
    all += pixels;
    if (id > 22) beyond_old += pixels;
  }
  const bool old_road = beyond_old == 0 && 50 * share_of(7) > all;
  return shippedLabelSet(old_road ? "carla" : "carla_0_9_14");
}

}  // namespace

RecordingListing listCarla(const std::string& folder, const InputOptions& options) {
  const fs::path root(folder);
  const Camera camera = readCamera((root / "camera.yaml").string());
  const auto depths = listFiles((root / "depth").string(), {".png"});
  const auto tags = listFiles((root / "semantic").string(), {".png"});
  requireSameFrames(folder, "depth", depths, "semantic", tags);
  const std::vector<std::int64_t> numbers = frameNumbers(depths);
  const std::vector<StampedPose> poses = posesOfFrames((root / "poses.txt").string(), numbers);

  RecordingListing listing;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    listing.frames.push_back(
        {numbers[i], poses[i].stamp_s, poses[i].T_frame_sensor, depths[i].path, tags[i].path, ""});
  }
  listing.read = [camera](const ListedFrame& listed, Frame& frame) {
    readImages(camera, listed, frame);
  };
  const auto named = namedLabels(options.labels, folder);
  listing.labels = named ? *named : carlaLabels(countLabels(listing, kFramesToLookAt));
  return listing;
}

}  // namespace xview
