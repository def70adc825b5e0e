// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace xview {

/// A row-major image of plain numbers. Empty when width or height is 0.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;

  Image() = default;
  Image(int w, int h, T value = T())
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}

  bool empty() const { return pixels.empty(); }
  T& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const T& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

using DepthImage = Image<float>;          ///< metres; 0 = no measurement
using LabelImage = Image<std::uint16_t>;  ///< class id, or instance id (0 = none)

inline bool isDepth(float z) { return z > 0 && z < 1e9f; }  ///< false for what is none

/// Red, green and blue of each pixel.
using ColorImage = Image<std::array<std::uint8_t, 3>>;

/// Pinhole camera; pixel (u, v) looks along ((u - cx) / fx, (v - cy) / fy, 1): x right, y down, z
/// forward.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;        ///< pixels
  double cx = 0, cy = 0;        ///< pixels
  double depth_scale = 1;       ///< metres per unit of an integer depth image
  bool depth_is_range = false;  ///< depth along the ray instead of along the optical axis
  double min_range_m = 0;       ///< what this camera measures nearer, or further, is not believed;
  double max_range_m = std::numeric_limits<double>::infinity();  ///< beside the limits of lifting

  /// p_sensor of a pixel of that depth.
  Eigen::Vector3d unproject(double u, double v, double depth) const {
    const Eigen::Vector3d ray((u - cx) / fx, (v - cy) / fy, 1);
    return depth_is_range ? Eigen::Vector3d(ray.normalized() * depth)
                          : Eigen::Vector3d(ray * depth);
  }
};

/// How a segmentation network wants its images, and what its answers mean.
struct NetworkInput {
  int width = 0, height = 0;  ///< size that the network sees [px]; 0 = that of the image
  /// A channel of the network is (value / 255 - mean) / std of a colour; in the order of `order`.
  std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};
  bool is_rgb = true;              ///< red first; else blue first
  std::vector<std::uint32_t> ids;  ///< class id of each output channel or value; empty = itself
  std::string labels;              ///< the label set of these ids: a shipped name or a file
};

}  // namespace xview
