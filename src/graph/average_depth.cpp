// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/average_depth.h"

#include <cmath>

#include "xview/types/median.h"

namespace xview::graph {
namespace {

constexpr float kAlike = 3.5F;     ///< times the noise: two measurements of one thing differ less
constexpr float kBehind_m = 0.1F;  ///< what is less in front of the camera is not seen

struct Sum {
  float inverse = 0, count = 0;
};

/// The measurements of another camera, each in the pixel of `frame` that looks at it.
void addSeenBy(const Frame& other, const Frame& frame, float limit, std::vector<Sum>& sums) {
  const Eigen::Isometry3f T = (frame.T_odom_sensor.inverse() * other.T_odom_sensor).cast<float>();
  const Camera& camera = frame.camera;
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy),
             cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  for (int v = 0; v < other.depth.height; ++v) {
    for (int u = 0; u < other.depth.width; ++u) {
      const float z = other.depth.at(u, v);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3f p = T * other.camera.unproject(u, v, z).cast<float>();
      if (!(p.z() > kBehind_m)) continue;
      const float inverse = 1 / p.z();
      const float x = std::round(fx * p.x() * inverse + cx),
                  y = std::round(fy * p.y() * inverse + cy);
      if (!(x >= 0 && y >= 0 && x < static_cast<float>(frame.depth.width) &&
            y < static_cast<float>(frame.depth.height)))
        continue;
      const std::size_t pixel =
          static_cast<std::size_t>(y) * frame.depth.width + static_cast<std::size_t>(x);
      const float own = frame.depth.pixels[pixel];
      const float told = camera.depth_is_range ? 1 / p.norm() : inverse;
      if (!(own > 0) || !(std::abs(told - 1 / own) < limit)) continue;
      sums[pixel].inverse += told;
      sums[pixel].count += 1;
    }
  }
}

}  // namespace

double medianDepth(const DepthImage& depth) {
  std::vector<float> measured;
  measured.reserve(depth.pixels.size());
  for (const float z : depth.pixels) {
    if (z > 0 && std::isfinite(z)) measured.push_back(z);
  }
  return measured.empty() ? 0 : medianOf(std::move(measured));
}

DepthImage averageDepth(const Frame& frame, const std::vector<const Frame*>& others,
                        double inverse_depth_sigma) {
  std::vector<Sum> sums(frame.depth.pixels.size());
  const float limit = kAlike * static_cast<float>(inverse_depth_sigma);
  for (const Frame* other : others) addSeenBy(*other, frame, limit, sums);
  DepthImage averaged = frame.depth;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    float& z = averaged.pixels[i];
    if (sums[i].count > 0) z = (1 + sums[i].count) / (1 / z + sums[i].inverse);
  }
  return averaged;
}

}  // namespace xview::graph
