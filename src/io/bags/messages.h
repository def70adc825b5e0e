// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "bag_file.h"
#include "io/point_table.h"
#include "xview/base/frame.h"

namespace xview::io {

// Messages of ROS that are read; one function reads both serializations. What does not fit is an
// Error of the cursor's file.

/// In the order in which odometry is preferred.
enum class Content {
  other,
  cloud,
  livox,
  image,
  compressed_image,
  camera_info,
  odometry,
  pose,
  pose_with_covariance,
  transform,
  transforms
};
Content contentOf(const std::string& type);
inline bool isKnown(const Channel& channel) { return contentOf(channel.type) != Content::other; }
/// "sensor_msgs/PointCloud2" of ROS 2's "sensor_msgs/msg/PointCloud2".
std::string plainType(const std::string& type);

inline bool isCloud(Content content) {
  return content == Content::cloud || content == Content::livox;
}
inline bool isImage(Content content) {
  return content == Content::image || content == Content::compressed_image;
}
inline bool isMotion(Content content) { return content >= Content::odometry; }

/// More than the headers of all messages take, and all of an odometry but its covariances [bytes].
constexpr std::uint64_t kHeadBytes = 4096;

struct MessageHeader {
  double stamp_s = 0;  ///< 0 = not given
  std::string frame;   ///< without a slash before it
};
MessageHeader readHeader(Cursor& cursor);

struct StampedTransform {
  MessageHeader header;
  std::string child;  ///< frame; empty if the message does not name it
  Eigen::Isometry3d T_frame_child = Eigen::Isometry3d::Identity();
};
/// Those of a message of isMotion(); transforms that are none (a quaternion of zeros, which drivers
/// send before they know better) are left out.
std::vector<StampedTransform> readTransforms(Cursor& cursor, Content content);

/// Rows in the message that the cursor reads.
struct CloudMessage {
  Element points;
  StoredRows rows;
};
/// Behind its header, of isCloud().
CloudMessage readCloudMessage(Cursor& cursor, Content content);

/// "16UC1" of an image behind its header, or "16UC1; compressedDepth png".
std::string readEncoding(Cursor& cursor, Content content);
bool isDepthEncoding(const std::string& encoding, Content content);
/// The depth of an image behind its header [m].
DepthImage readDepthMessage(Cursor& cursor, Content content, const Camera& camera);
/// Of a camera info behind its header.
Camera readCameraInfo(Cursor& cursor);

}  // namespace xview::io
