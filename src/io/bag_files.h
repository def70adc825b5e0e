// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "xview/io/recording.h"

namespace xview::io {

/// What a bag has under one name.
struct BagTopic {
  std::string name;
  std::string type;  ///< "sensor_msgs/PointCloud2"
  std::uint64_t messages = 0;
  double duration_s = 0;  ///< from the first to the last, by the clock of the recorder
  std::string taken_as;   ///< "clouds", "depth", "camera", "poses"; empty = it is not read
};

/// A rosbag2 (.mcap, .db3, or the folder with metadata.yaml around them) or a ROS 1 .bag.
bool isBag(const std::string& path);
/// Its topics by name, and which of them openRecording() would read. Throws Error, or UsageError if
/// options.topic or options.odometry is none of them.
std::vector<BagTopic> bagTopics(const std::string& path, const InputOptions& options = {});
/// T_base_sensor of the measurements that openRecording() would read, by the static transforms of
/// the bag: of the base that its odometry moves, mostly base_link. Nothing if they do not say.
std::optional<Eigen::Isometry3d> mountingIn(const std::string& path, const InputOptions& options);

}  // namespace xview::io
