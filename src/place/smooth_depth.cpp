// SPDX-License-Identifier: BSD-3-Clause
#include "place/smooth_depth.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/median.h"

namespace xview {
namespace {

constexpr int kApart = 6;          ///< pixels over which errors are independent
constexpr double kOfPixels = 0.2;  ///< of the noise, what neighbouring pixels show of it at least
constexpr int kEvery = 3;          ///< rows and columns looked at
constexpr std::size_t kFewest = 200;          ///< second differences that tell the noise
constexpr double kMedianOfAbs = 0.6745;       ///< of the standard normal distribution
constexpr double kNoiseOfSecond = 2.4494897;  ///< root of 1 + 4 + 1

/// From second differences over pixels this far apart.
double noiseOver(const DepthImage& depth, int step) {
  std::vector<float> seconds;
  for (int y = 0; y < depth.height; y += kEvery) {
    for (int x = step; x + step < depth.width; x += kEvery) {
      const float left = depth.at(x - step, y), middle = depth.at(x, y),
                  right = depth.at(x + step, y);
      if (!(left > 0 && middle > 0 && right > 0)) continue;
      seconds.push_back(std::abs(1 / left - 2 / middle + 1 / right));
    }
  }
  if (seconds.size() < kFewest) return 0;
  return medianOf(std::move(seconds)) / (kMedianOfAbs * kNoiseOfSecond);
}

constexpr int kBlock_px = 4;
constexpr int kLargest = 2;           ///< blocks to each side of a window
constexpr double kFewestPixels = 12;  ///< of a window
constexpr double kExplained = 1.4;    ///< times the noise, squared: what a plane may leave
constexpr double kMeanError = 1.2;    ///< times the noise: what the mean of one block may be off

/// Calls visit(u, v, z) for the measured pixels of a block.
template <class Image, class Visit>
void forMeasured(Image& depth, int x, int y, const Visit& visit) {
  for (int v = y * kBlock_px; v < std::min((y + 1) * kBlock_px, depth.height); ++v) {
    for (int u = x * kBlock_px; u < std::min((x + 1) * kBlock_px, depth.width); ++u) {
      auto& z = depth.at(u, v);
      if (z > 0 && z < 1e9F) visit(u, v, z);
    }
  }
}

/// Sums over pixels; w is the inverse depth in units of its noise.
struct Moments {
  /// n, u, v, w, uu, uv, vv, uw, vw, ww: one array, which is added at once.
  Eigen::Array<double, 10, 1> sums = Eigen::Array<double, 10, 1>::Zero();

  void add(double u, double v, double w) {
    const double pixel[] = {1, u, v, w, u * u, u * v, v * v, u * w, v * w, w * w};
    sums += Eigen::Map<const Eigen::Array<double, 10, 1>>(pixel);
  }
  double n() const { return sums[0]; }
  Eigen::Vector2d meanPixel() const { return sums.segment<2>(1) / n(); }
  double meanW() const { return sums[3] / n(); }
};

/// w = w0 + slope . (pixel - middle)
struct Plane {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), slope = Eigen::Vector2d::Zero();
  double w0 = 0;
  double leaves = 0;  ///< mean square of the residuals
  double at(const Eigen::Vector2d& pixel) const { return w0 + slope.dot(pixel - middle); }
};

Plane planeThrough(const Moments& m) {
  Plane plane;
  plane.middle = m.meanPixel();
  plane.w0 = m.meanW();
  Eigen::Matrix2d spread;
  spread << m.sums[4], m.sums[5], m.sums[5], m.sums[6];
  spread -= m.n() * plane.middle * plane.middle.transpose();
  spread.diagonal().array() += 1e-3 * m.n();  // one row of pixels has no slope across
  const Eigen::Vector2d pull = m.sums.segment<2>(7).matrix() - m.sums[3] * plane.middle;
  plane.slope = spread.inverse() * pull;
  plane.leaves = std::max(0.0, m.sums[9] - m.sums[3] * plane.w0 - plane.slope.dot(pull)) /
                 std::max(1.0, m.n() - 3);
  return plane;
}

/// The pixels of one label in a block.
struct Part {
  std::uint16_t label;
  Moments moments;
};

/// The parts of all blocks of an image, row by row.
class Blocks {
 public:
  Blocks(const DepthImage& depth, const LabelImage& labels, double sigma)
      : across_((depth.width + kBlock_px - 1) / kBlock_px),
        down_((depth.height + kBlock_px - 1) / kBlock_px) {
    for (int y = 0; y < down_; ++y) {
      for (int x = 0; x < across_; ++x) {
        const auto begin = static_cast<std::ptrdiff_t>(parts_.size());
        first_.push_back(parts_.size());
        forMeasured(depth, x, y, [&](int u, int v, float z) {
          const std::uint16_t label = labels.at(u, v);
          auto part = std::find_if(parts_.begin() + begin, parts_.end(),
                                   [&](const Part& p) { return p.label == label; });
          if (part == parts_.end()) part = parts_.insert(part, {label, {}});
          part->moments.add(u, v, 1 / (sigma * z));
        });
      }
    }
    first_.push_back(parts_.size());
  }

  void smooth(DepthImage& depth, const LabelImage& labels, double sigma, double good_m) const {
    for (int y = 0; y < down_; ++y) {
      for (int x = 0; x < across_; ++x) {
        for (std::size_t i = begin(x, y); i < end(x, y); ++i) {
          const double inverse = parts_[i].moments.meanW() * sigma;
          Plane plane;
          if (sigma < good_m * inverse * inverse || !findPlane(parts_[i], x, y, plane)) continue;
          forMeasured(depth, x, y, [&](int u, int v, float& z) {
            const double w = plane.at(Eigen::Vector2d(u, v)) * sigma;
            if (w > 0 && labels.at(u, v) == parts_[i].label) z = static_cast<float>(1 / w);
          });
        }
      }
    }
  }

 private:
  std::size_t begin(int x, int y) const { return first_[y * across_ + x]; }
  std::size_t end(int x, int y) const { return first_[y * across_ + x + 1]; }

  Moments window(std::uint16_t label, int x, int y, int radius) const {
    Moments sum;
    const int left = std::max(0, x - radius), right = std::min(across_ - 1, x + radius);
    for (int by = std::max(0, y - radius); by <= std::min(down_ - 1, y + radius); ++by) {
      for (std::size_t i = begin(left, by); i < end(right, by); ++i)
        if (parts_[i].label == label) sum.sums += parts_[i].moments.sums;
    }
    return sum;
  }

  bool findPlane(const Part& part, int x, int y, Plane& plane) const {
    for (int radius = kLargest; radius >= 0; --radius) {
      const Moments m = window(part.label, x, y, radius);
      if (m.n() < kFewestPixels) return false;
      plane = planeThrough(m);
      const double off = part.moments.meanW() - plane.at(part.moments.meanPixel());
      if (plane.leaves <= kExplained && std::abs(off) <= kMeanError) return true;
    }
    return false;
  }

  int across_, down_;
  std::vector<std::size_t> first_;  ///< part of each block, and the end
  std::vector<Part> parts_;
};

// ---- averages over several cameras

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

double inverseDepthNoise(const DepthImage& depth) { return noiseOver(depth, kApart); }

void setSigmas(double inverse_depth_noise, const Eigen::Vector3d& p_sensor, LabelledCloud& cloud) {
  if (inverse_depth_noise <= 0) return;
  const Eigen::Vector3f sensor = (p_sensor - cloud.origin).cast<float>();
  for (Point& point : cloud.points) {
    const double range = (point.getVector3fMap() - sensor).norm();
    point.sigma = static_cast<float>(inverse_depth_noise * range * range);
  }
}

bool isNoiseOfPixels(double inverse_depth_noise, const DepthImage& depth) {
  return inverse_depth_noise > 0 && noiseOver(depth, 1) >= kOfPixels * inverse_depth_noise;
}

void smoothDepth(DepthImage& depth, const LabelImage& labels, double inverse_depth_sigma,
                 double good_m) {
  if (inverse_depth_sigma <= 0 || depth.empty()) return;
  Blocks(depth, labels, inverse_depth_sigma).smooth(depth, labels, inverse_depth_sigma, good_m);
}

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

}  // namespace xview
