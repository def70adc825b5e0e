// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "xview/io/recording.h"

namespace xview {

/// A frame before it is read.
struct ListedFrame {
  std::int64_t number = 0;
  double stamp_s = 0;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  std::string measurement;  ///< path of the depth image or cloud
  std::string label;        ///< path of the label file, if the measurement does not hold them
  std::string instance;     ///< path of the instance image; empty = none
};

/// All that one layout has to say about a recording. The reader fills the images or the cloud of
/// the frame; it is called from several threads.
struct RecordingListing {
  Sensor sensor = Sensor::camera;
  LabelSet labels;
  std::vector<ListedFrame> frames;
  std::function<void(const ListedFrame&, Frame&)> read;
};

/// The frames of the range as a recording. Throws UsageError if the range is beyond the last frame.
std::unique_ptr<FrameSource> makeRecording(const std::string& name, RecordingListing listing,
                                           const FrameRange& range);

/// How often each class id occurs in at most `max_frames` frames spread over the recording.
using LabelCounts = std::map<std::uint32_t, std::uint64_t>;
LabelCounts countLabels(const RecordingListing& listing, std::size_t max_frames);

/// Throws Error if two images of a frame differ in size.
void requireSameSize(const std::string& path, int width, int height, const std::string& other_path,
                     int other_width, int other_height);

}  // namespace xview
