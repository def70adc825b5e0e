// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace xview::test {

// A writer of bags and of messages of ROS, from their specifications and not by the library.

enum class Wire { ros1, cdr_little, cdr_big };

/// Values one behind the other, as one of the serializations has them.
class MessageWriter {
 public:
  explicit MessageWriter(Wire wire);
  template <class T>
  MessageWriter& number(T value) {
    align(sizeof(T));
    return put(reinterpret_cast<const char*>(&value), sizeof(T), wire_ == Wire::cdr_big);
  }
  MessageWriter& text(const std::string& text);
  MessageWriter& raw(const std::string& bytes) { return put(bytes.data(), bytes.size(), false); }
  MessageWriter& header(double stamp_s, const std::string& frame);
  /// Position and quaternion.
  MessageWriter& pose(const Eigen::Isometry3d& T);
  void align(std::size_t bytes);
  const std::string& bytes() const { return bytes_; }

 private:
  MessageWriter& put(const char* bytes, std::size_t count, bool reversed);
  Wire wire_;
  std::size_t origin_ = 0;
  std::string bytes_;
};

/// A column of a PointCloud2; types as PointField numbers them.
struct CloudField {
  std::string name;
  std::uint32_t offset;
  std::uint8_t type;
};
struct CloudLayout {
  std::vector<CloudField> fields;
  std::uint32_t point_bytes = 0, width = 0, height = 1, line_bytes = 0;
  bool big_endian = false;
};
std::string cloudMessage(Wire wire, double stamp_s, const std::string& frame,
                         const CloudLayout& layout, const std::string& data);
/// x, y, z and a label, of float32 and uint32.
std::string labelledCloudMessage(Wire wire, double stamp_s, const std::string& frame,
                                 const std::vector<Eigen::Vector4f>& points);
std::string livoxMessage(Wire wire, double stamp_s, const std::string& frame,
                         const std::vector<Eigen::Vector3f>& points);
std::string odometryMessage(Wire wire, double stamp_s, const std::string& frame,
                            const std::string& child, const Eigen::Isometry3d& T);
struct Transform {
  double stamp_s;
  std::string frame, child;
  Eigen::Isometry3d T;
};
std::string transformsMessage(Wire wire, const std::vector<Transform>& transforms);
/// What of a sensor its images show: one of so many pixels, of a region.
struct ImagePart {
  std::uint32_t binning = 0, x = 0, y = 0, width = 0, height = 0;
};
std::string cameraInfoMessage(Wire wire, const std::string& frame, std::uint32_t width,
                              std::uint32_t height, double f, const ImagePart& part = {},
                              const std::string& lens = "plumb_bob", double distortion = 0);

/// Compressed with "zstd", "lz4" or "bz2".
std::string packed(const std::string& compression, const std::string& bytes);

struct BagMessage {
  std::string topic, type;  ///< "sensor_msgs/PointCloud2"
  std::int64_t log_ns;
  std::string bytes;
};
struct LogShape {
  std::string compression;  ///< "zstd", "lz4", "bz2"; empty = none
  bool is_closed = true;    ///< with a summary at its end
  bool has_chunks = true;   ///< of MCAP
  bool has_indices = true;  ///< behind the chunks
  std::size_t chunk_messages = 3;
  std::string encoding = "cdr";  ///< of the messages in an MCAP
};
std::string mcapBytes(const std::vector<BagMessage>& messages, const LogShape& shape);
std::string rosBagBytes(const std::vector<BagMessage>& messages, const LogShape& shape);
void writeDatabase(const std::string& path, const std::vector<BagMessage>& messages);
/// By the ending of the path; the messages are those of ROS 1 in a .bag.
void writeBag(const std::string& path, const std::vector<BagMessage>& messages,
              const LogShape& shape = {});

}  // namespace xview::test
