// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include "frame_listing.h"
#include "label_choice.h"
#include "recording_layouts.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCloudsToLookAt = 32;

RecordingListing cloudListing(Sensor sensor, const InputOptions& options) {
  RecordingListing listing;
  listing.sensor = sensor;
  const CloudFields fields{options.label_field, options.instance_field};
  listing.read = [fields](const ListedFrame& listed, Frame& frame) {
    frame.cloud = readCloud(listed.measurement, fields, true, &frame.rings);
  };
  return listing;
}

/// `cloud` is one of the recording; what it says of its classes holds for all.
void chooseLabels(RecordingListing& listing, const InputOptions& options, const fs::path& folder,
                  const std::string& cloud) {
  const CloudFields fields{options.label_field, options.instance_field};
  const auto named =
      namedLabels(options.labels, folder.string(), readCloudHeader(cloud, fields).labels);
  listing.labels = named ? *named : labelsOfIds(countLabels(listing, kCloudsToLookAt), options);
}

}  // namespace

RecordingListing listCloud(const std::string& path, const InputOptions& options) {
  RecordingListing listing = cloudListing(Sensor::cloud, options);
  ListedFrame frame;
  frame.measurement = path;
  listing.frames = {frame};
  chooseLabels(listing, options, fs::absolute(path).parent_path(), path);
  return listing;
}

RecordingListing listCloudFolder(const std::string& folder, const InputOptions& options) {
  RecordingListing listing = cloudListing(Sensor::lidar, options);
  const auto clouds = listFiles(folder, {".pcd", ".ply"});
  const std::vector<std::int64_t> numbers = frameNumbers(clouds);
  const fs::path poses_path = fs::path(folder) / "poses.txt";
  std::vector<StampedPose> poses(1);
  if (clouds.size() > 1 || fs::exists(poses_path))
    poses = posesOfFrames(poses_path.string(), numbers);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    listing.frames.push_back(
        {numbers[i], poses[i].stamp_s, poses[i].T_frame_sensor, clouds[i].path, "", ""});
  }
  chooseLabels(listing, options, folder, clouds.front().path);
  return listing;
}

}  // namespace xview
