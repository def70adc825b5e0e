// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include "frame_listing.h"
#include "label_choice.h"
#include "recording_layouts.h"
#include "xview/io/image_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"
#include "xview/types/error.h"

namespace xview {
namespace {

/// Label images are looked at in this many frames when nothing names the classes.
constexpr std::size_t kFramesToLookAt = 32;

void readImages(const Camera& camera, const ListedFrame& listed, Frame& frame) {
  frame.camera = camera;
  frame.depth = readDepth(listed.measurement, camera);
  frame.label = readLabels(listed.label);
  requireSameSize(listed.label, frame.label.width, frame.label.height, listed.measurement,
                  frame.depth.width, frame.depth.height);
  if (listed.instance.empty()) return;
  frame.instance = readLabels(listed.instance);
  requireSameSize(listed.instance, frame.instance.width, frame.instance.height, listed.measurement,
                  frame.depth.width, frame.depth.height);
}

}  // namespace

RecordingListing listSequence(const std::string& folder, const InputOptions& options) {
  const std::filesystem::path root(folder);
  const Camera camera = readCamera((root / "camera.yaml").string());
  const auto depths =
      listFiles((root / "depth").string(), {".png", ".tif", ".tiff", ".exr", ".pfm"});
  const auto labels = listFiles((root / "label").string(), {".png", ".tif", ".tiff"});
  requireSameFrames(folder, "depth", depths, "label", labels);
  std::vector<NumberedFile> instances;
  if (std::filesystem::is_directory(root / "instance")) {
    instances = listFiles((root / "instance").string(), {".png", ".tif", ".tiff"});
    requireSameFrames(folder, "depth", depths, "instance", instances);
  }
  const std::vector<std::int64_t> numbers = frameNumbers(depths);
  const std::vector<StampedPose> poses = posesOfFrames((root / "poses.txt").string(), numbers);

  RecordingListing listing;
  listing.sensor = Sensor::camera;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    listing.frames.push_back({numbers[i], poses[i].stamp_s, poses[i].T_frame_sensor, depths[i].path,
                              labels[i].path,
                              instances.empty() ? std::string() : instances[i].path});
  }
  listing.read = [camera](const ListedFrame& listed, Frame& frame) {
    readImages(camera, listed, frame);
  };
  const auto named = namedLabels(options.labels, folder);
  listing.labels = named ? *named : labelsOfIds(countLabels(listing, kFramesToLookAt), options);
  return listing;
}

}  // namespace xview
