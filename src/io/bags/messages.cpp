// SPDX-License-Identifier: BSD-3-Clause
#include "messages.h"

#include <cmath>
#include <opencv2/core/mat.hpp>

#include "base/pose.h"
#include "io/image_decoding.h"
#include "io/layouts.h"

namespace xview::io {
namespace {

constexpr std::pair<const char*, Content> kTypes[] = {
    {"sensor_msgs/PointCloud2", Content::cloud},
    {"livox_ros_driver/CustomMsg", Content::livox},
    {"livox_ros_driver2/CustomMsg", Content::livox},
    {"livox_interfaces/CustomMsg", Content::livox},
    {"sensor_msgs/Image", Content::image},
    {"sensor_msgs/CompressedImage", Content::compressed_image},
    {"sensor_msgs/CameraInfo", Content::camera_info},
    {"nav_msgs/Odometry", Content::odometry},
    {"geometry_msgs/PoseStamped", Content::pose},
    {"geometry_msgs/PoseWithCovarianceStamped", Content::pose_with_covariance},
    {"geometry_msgs/TransformStamped", Content::transform},
    {"tf2_msgs/TFMessage", Content::transforms},
    {"tf/tfMessage", Content::transforms}};

std::string frameName(std::string_view text) {
  return std::string(text.substr(text.empty() || text[0] != '/' ? 0 : 1));
}

/// Position and quaternion x y z w, of a pose as of a transform.
void readTransform(Cursor& cursor, bool has_child, std::vector<StampedTransform>& transforms) {
  StampedTransform result;
  result.header = readHeader(cursor);
  if (has_child) result.child = frameName(cursor.text());
  double n[7];
  for (double& value : n) value = cursor.number<double>();
  const Eigen::Vector3d position(n[0], n[1], n[2]);
  const Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
  if (!position.allFinite() || !(std::abs(q.norm() - 1) < 0.01)) return;
  result.T_frame_child = poseOf(q.normalized().toRotationMatrix(), position);
  transforms.push_back(result);
}

// ---- clouds

/// PointField numbers the types from 1.
constexpr ScalarType kFieldTypes[] = {ScalarType::i8,  ScalarType::u8,  ScalarType::i16,
                                      ScalarType::u16, ScalarType::i32, ScalarType::u32,
                                      ScalarType::f32, ScalarType::f64};

/// Throws Error unless the rows lie within this number of bytes.
void requireRows(const Cursor& cursor, const CloudMessage& cloud, std::uint64_t bytes) {
  const StoredRows& rows = cloud.rows;
  std::uint64_t row_end = 0;
  for (std::size_t i = 0; i < cloud.points.columns.size(); ++i) {
    const Column& column = cloud.points.columns[i];
    row_end = std::max(row_end, rows.offsets[i] + column.count * sizeOf(column.type));
  }
  if (row_end > rows.row_bytes)
    cursor.fail("points of {} bytes, but their fields take {}", rows.row_bytes, row_end);
  const std::uint64_t lines = cloud.points.rows / rows.line_rows;
  const auto fits = [&](std::uint64_t count, std::uint64_t each, std::uint64_t room) {
    return count == 0 || each <= room / count;
  };
  const bool is_within = fits(rows.line_rows, rows.row_bytes, bytes + rows.row_bytes - row_end) &&
                         fits(lines - 1, rows.line_bytes, bytes) &&
                         rows.line_rows * rows.row_bytes - (rows.row_bytes - row_end) <=
                             bytes - (lines - 1) * rows.line_bytes;
  if (!is_within)
    cursor.fail("{} points of {} bytes in {} bytes", cloud.points.rows, rows.row_bytes, bytes);
}

CloudMessage readPointCloud2(Cursor& cursor) {
  CloudMessage cloud;
  cloud.points.name = "point";
  const std::uint64_t height = cursor.number<std::uint32_t>(),
                      width = cursor.number<std::uint32_t>();
  cloud.points.rows = height * width;
  for (std::uint32_t fields = cursor.count(13); fields > 0; --fields) {
    const std::string name(cursor.text());
    const std::uint64_t offset = cursor.number<std::uint32_t>();
    const auto type = cursor.number<std::uint8_t>();
    const auto count = cursor.number<std::uint32_t>();
    if (type == 0 || type > std::size(kFieldTypes)) continue;  // none that can be read
    cloud.points.columns.push_back({name, kFieldTypes[type - 1], std::max(count, 1U), {}});
    cloud.rows.offsets.push_back(offset);
  }
  cloud.rows.big_endian = cursor.number<std::uint8_t>() != 0;
  cloud.rows.row_bytes = cursor.number<std::uint32_t>();
  const std::uint64_t line_bytes = cursor.number<std::uint32_t>();
  const std::string_view data = cursor.take(cursor.number<std::uint32_t>());
  cloud.rows.bytes = data.data();
  cloud.rows.line_rows = std::max<std::uint64_t>(1, width);
  // Drivers that have no lines leave their length out.
  cloud.rows.line_bytes = std::max(line_bytes, width * cloud.rows.row_bytes);
  if (cloud.points.rows > 0) requireRows(cursor, cloud, data.size());
  return cloud;
}

CloudMessage readLivox(Cursor& cursor) {
  cursor.number<std::uint64_t>();  // time base
  CloudMessage cloud;
  cursor.number<std::uint32_t>();  // number of points, as the sequence has it again
  cursor.take(4);                  // number of the scanner, reserved
  cloud.points.name = "point";
  cloud.points.rows = cursor.count(19);
  cloud.points.columns = {{"offset_time", ScalarType::u32, 1, {}}, {"x", ScalarType::f32, 1, {}},
                          {"y", ScalarType::f32, 1, {}},           {"z", ScalarType::f32, 1, {}},
                          {"reflectivity", ScalarType::u8, 1, {}}, {"tag", ScalarType::u8, 1, {}},
                          {"line", ScalarType::u8, 1, {}}};
  cloud.rows.offsets = {0, 4, 8, 12, 16, 17, 18};
  cloud.rows.row_bytes = cursor.isRos1() ? 19 : 20;
  cloud.rows.line_rows = std::max<std::uint64_t>(1, cloud.points.rows);
  cloud.rows.big_endian = cursor.isBigEndian();
  const std::string_view data = cursor.take(cursor.remaining());
  cloud.rows.bytes = data.data();
  if (cloud.points.rows > 0) requireRows(cursor, cloud, data.size());
  return cloud;
}

// ---- images

constexpr double kMillimetre_m = 0.001;

/// Of raw pixels.
cv::Mat pixelsOf(Cursor& cursor, const Camera& camera) {
  const auto height = cursor.number<std::uint32_t>(), width = cursor.number<std::uint32_t>();
  requireSameSize(cursor.file().path(), width, height, "its camera info", camera.width,
                  camera.height);
  const bool is_float = cursor.text() == "32FC1";
  const bool big_endian = cursor.number<std::uint8_t>() != 0;
  const std::size_t step = cursor.number<std::uint32_t>(), each = is_float ? 4 : 2;
  const std::string_view data = cursor.take(cursor.number<std::uint32_t>());
  if (step < each * width || data.size() / height < step)
    cursor.fail("{} x {} pixels in {} bytes, {} a line", width, height, data.size(), step);
  cv::Mat image(camera.height, camera.width, is_float ? CV_32F : CV_16U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const char* pixel =
          data.data() + static_cast<std::size_t>(y) * step + static_cast<std::size_t>(x) * each;
      if (is_float)
        image.at<float>(y, x) = storedNumber<float>(pixel, big_endian);
      else
        image.at<std::uint16_t>(y, x) = storedNumber<std::uint16_t>(pixel, big_endian);
    }
  }
  return image;
}

/// Depth packed by RVL (Wilson, "Fast Lossless Depth Image Compression", ISS 2017): by turns how
/// many pixels are zero, and how many are not with their differences, in numbers of four bits at a
/// time, the highest of which says whether more follow.
class RvlReader {
 public:
  RvlReader(Cursor& cursor, std::string_view data) : cursor_(cursor), data_(data) {}

  cv::Mat read(int width, int height) {
    cv::Mat image(height, width, CV_16UC1, cv::Scalar(0));
    auto* const pixels = image.ptr<std::uint16_t>();
    const auto all = static_cast<std::uint32_t>(width) * static_cast<std::uint32_t>(height);
    std::uint32_t last = 0;  // modulo 2^16, as it is stored
    for (std::uint32_t i = 0; i < all;) {
      i += countOf(all - i);
      for (std::uint32_t some = countOf(all - i); some > 0; --some) {
        const std::uint32_t folded = number();
        last += (folded >> 1) ^ (0U - (folded & 1));
        pixels[i++] = static_cast<std::uint16_t>(last);
      }
    }
    return image;
  }

 private:
  std::uint32_t countOf(std::uint32_t most) {
    const std::uint32_t count = number();
    if (count > most) cursor_.fail("depth packed by RVL has {} pixels too many", count - most);
    return count;
  }
  std::uint32_t number() {
    std::uint32_t value = 0, nibble = 8;
    for (int shift = 0; nibble & 8; shift += 3) {
      if (shift > 30) cursor_.fail("depth packed by RVL has a number of more than 32 bits");
      if (left_ == 0) {
        if (at_ + 4 > data_.size()) cursor_.fail("depth packed by RVL ends at byte {}", at_);
        word_ = storedNumber<std::uint32_t>(data_.data() + at_, false);
        at_ += 4;
        left_ = 8;
      }
      nibble = word_ >> 28;
      word_ <<= 4;
      --left_;
      value |= (nibble & 7) << shift;
    }
    return value;
  }

  Cursor& cursor_;
  std::string_view data_;
  std::size_t at_ = 0;
  std::uint32_t word_ = 0;
  int left_ = 0;  ///< numbers of four bits in the word
};

cv::Mat unpackedRvl(Cursor& cursor, std::string_view data, const Camera& camera) {
  if (data.size() < 8) cursor.fail("depth packed by RVL of {} bytes", data.size());
  const auto width = storedNumber<std::int32_t>(data.data(), false),
             height = storedNumber<std::int32_t>(data.data() + 4, false);
  requireSameSize(cursor.file().path(), width, height, "its camera info", camera.width,
                  camera.height);
  const std::uint64_t bytes = sizeof(std::uint16_t) * static_cast<std::uint64_t>(width) *
                              static_cast<std::uint64_t>(height);
  if (bytes > mostUnpacked(cursor.file()))
    cursor.fail("depth of {} x {} pixels in a file of {} bytes", width, height,
                cursor.file().size());
  return RvlReader(cursor, data.substr(8)).read(width, height);
}

cv::Mat unpackedPng(Cursor& cursor, std::string_view data, const Camera& camera) {
  const std::vector<unsigned char> png(data.begin(), data.end());
  const PngHeader header = checkPng(cursor.file().path(), png);
  requireSameSize(cursor.file().path(), header.width, header.height, "its camera info",
                  camera.width, camera.height);
  const cv::Mat image = decodePng(header, png);
  if (image.type() != CV_16UC1) cursor.fail("expected depth as a PNG of 16 bits");
  return image;
}

/// compressed_depth_image_transport: a kind, two numbers of its quantization, and a PNG or RVL with
/// 16-bit depth or, if it was float, its quantized inverse.
cv::Mat unpackedPixels(Cursor& cursor, const Camera& camera) {
  const std::string kind(cursor.text());
  const bool is_float = kind.substr(0, 5) == "32FC1";
  const std::string_view data = cursor.take(cursor.number<std::uint32_t>());
  if (data.size() < 12) cursor.fail("a compressed depth image of {} bytes", data.size());
  const auto a = storedNumber<float>(data.data() + 4, false),
             b = storedNumber<float>(data.data() + 8, false);
  const cv::Mat image = kind.find("rvl") != std::string::npos
                            ? unpackedRvl(cursor, data.substr(12), camera)
                            : unpackedPng(cursor, data.substr(12), camera);
  if (!is_float) return image;
  cv::Mat depth(image.rows, image.cols, CV_32F, 0.0F);
  for (int i = 0; i < image.rows * image.cols; ++i) {
    const std::uint16_t stored = image.at<std::uint16_t>(i / image.cols, i % image.cols);
    if (stored > 0) depth.at<float>(i / image.cols, i % image.cols) = a / (stored - b);
  }
  return depth;
}

}  // namespace

Content contentOf(const std::string& type) {
  for (const auto& [name, content] : kTypes) {
    if (type == name) return content;
  }
  return Content::other;
}

std::string plainType(const std::string& type) {
  const std::size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

MessageHeader readHeader(Cursor& cursor) {
  if (cursor.isRos1()) cursor.number<std::uint32_t>();  // sequence number
  MessageHeader header;
  header.stamp_s = cursor.number<std::uint32_t>();
  header.stamp_s += 1e-9 * cursor.number<std::uint32_t>();
  header.frame = frameName(cursor.text());
  return header;
}

std::vector<StampedTransform> readTransforms(Cursor& cursor, Content content) {
  const bool has_child = content != Content::pose && content != Content::pose_with_covariance;
  std::vector<StampedTransform> transforms;
  std::uint32_t count = content == Content::transforms ? cursor.count(64) : 1;
  for (; count > 0; --count) readTransform(cursor, has_child, transforms);
  return transforms;
}

CloudMessage readCloudMessage(Cursor& cursor, Content content) {
  return content == Content::livox ? readLivox(cursor) : readPointCloud2(cursor);
}

std::string readEncoding(Cursor& cursor, Content content) {
  if (content == Content::image) {
    cursor.number<std::uint32_t>();
    cursor.number<std::uint32_t>();
  }
  return std::string(cursor.text());
}

bool isDepthEncoding(const std::string& encoding, Content content) {
  if (content == Content::compressed_image)
    return encoding.find("compressedDepth") != std::string::npos;
  return encoding == "16UC1" || encoding == "mono16" || encoding == "32FC1";
}

DepthImage readDepthMessage(Cursor& cursor, Content content, const Camera& camera) {
  return depthOfPixels(
      content == Content::image ? pixelsOf(cursor, camera) : unpackedPixels(cursor, camera),
      kMillimetre_m, cursor.file().path());
}

namespace {

/// Of the sensor an image may be a region, and of that every so many pixels.
void takePart(Cursor& cursor, Camera& camera) {
  const auto one = [&] {
    return static_cast<double>(std::max(1U, cursor.number<std::uint32_t>()));
  };
  const double binning_x = one(), binning_y = one();
  const auto x = cursor.number<std::uint32_t>(), y = cursor.number<std::uint32_t>(),
             height = cursor.number<std::uint32_t>(), width = cursor.number<std::uint32_t>();
  const auto part = [&](std::uint32_t whole, std::uint32_t offset, std::uint32_t some,
                        double binning) {
    if (some == 0) some = whole;
    if (std::uint64_t{offset} + some > whole)
      cursor.fail("a camera info whose region of interest, {} from {} on, is not within {} pixels",
                  some, offset, whole);
    return static_cast<int>(some / binning);
  };
  camera.width = part(static_cast<std::uint32_t>(camera.width), x, width, binning_x);
  camera.height = part(static_cast<std::uint32_t>(camera.height), y, height, binning_y);
  camera.fx /= binning_x;
  camera.fy /= binning_y;
  camera.cx = (camera.cx - x + 0.5) / binning_x - 0.5;
  camera.cy = (camera.cy - y + 0.5) / binning_y - 0.5;
}

}  // namespace

Camera readCameraInfo(Cursor& cursor) {
  constexpr std::uint32_t kMostPixels = 32768;
  const auto height = cursor.number<std::uint32_t>(), width = cursor.number<std::uint32_t>();
  const std::string distortion(cursor.text());
  double most_distorted = 0;
  for (std::uint32_t i = cursor.count(8); i > 0; --i)
    most_distorted = std::max(most_distorted, std::abs(cursor.number<double>()));
  double k[9], p[12];
  for (double& value : k) value = cursor.number<double>();
  for (int i = 0; i < 9; ++i) cursor.number<double>();  // R
  for (double& value : p) value = cursor.number<double>();
  const bool is_rectified = p[0] > 0;
  if (!is_rectified && distortion != "plumb_bob" && distortion != "rational_polynomial" &&
      !distortion.empty() && most_distorted > 0)
    cursor.fail(
        "a camera info of the lens model {}, whose images are not rectified (P is 0); rectify them "
        "first, as image_proc does",
        inQuotes(distortion));
  Camera camera;
  camera.width = static_cast<int>(std::min(width, kMostPixels + 1));
  camera.height = static_cast<int>(std::min(height, kMostPixels + 1));
  camera.fx = is_rectified ? p[0] : k[0];
  camera.cx = is_rectified ? p[2] : k[2];
  camera.fy = is_rectified ? p[5] : k[4];
  camera.cy = is_rectified ? p[6] : k[5];
  camera.depth_scale = kMillimetre_m;
  takePart(cursor, camera);
  const bool is_whole =
      camera.width > 0 && camera.height > 0 && width <= kMostPixels && height <= kMostPixels;
  if (!is_whole || !(camera.fx > 0 && camera.fy > 0) ||
      !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy))
    cursor.fail("a camera info of {} x {} pixels with focal lengths {} and {}", width, height,
                camera.fx, camera.fy);
  return camera;
}

}  // namespace xview::io
