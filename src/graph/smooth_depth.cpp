// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/smooth_depth.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "graph/block_moments.h"

namespace xview::graph {
namespace {

constexpr int kLargest = 2;           ///< blocks to each side of a window
constexpr double kFewestPixels = 12;  ///< of a window
constexpr double kExplained = 1.4;    ///< times the noise, squared: what a plane may leave
constexpr double kMeanError = 1.2;    ///< times the noise: what the mean of one block may be off

/// Sums of moments. As pairs of numbers they stay in registers, which is worth a third of it all.
class MomentSum {
 public:
  void add(const Moments& m) {
    n_u_ += pairAt(m.n);
    v_w_ += pairAt(m.v);
    uu_uv_ += pairAt(m.uu);
    vv_uw_ += pairAt(m.vv);
    vw_ww_ += pairAt(m.vw);
  }
  Moments total() const {
    return {n_u_[0],   n_u_[1],   v_w_[0],   v_w_[1],   uu_uv_[0],
            uu_uv_[1], vv_uw_[0], vv_uw_[1], vw_ww_[0], vw_ww_[1]};
  }

 private:
  using Pair = double __attribute__((vector_size(16)));
  static Pair pairAt(const double& first) {
    Pair pair;
    std::memcpy(&pair, &first, sizeof pair);
    return pair;
  }
  Pair n_u_{}, v_w_{}, uu_uv_{}, vv_uw_{}, vw_ww_{};
};

/// w = w0 + a (u - u0) + b (v - v0)
struct Plane {
  double u0, v0, w0, a, b;
  double leaves;  ///< mean square of the residuals
  double at(double u, double v) const { return w0 + a * (u - u0) + b * (v - v0); }
};

/// By LDL^T with the larger element of the diagonal first, which is positive.
Eigen::Vector2d solveSymmetric(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& right) {
  const int first = matrix(1, 1) > matrix(0, 0) ? 1 : 0, second = 1 - first;
  const double d0 = matrix(first, first), factor = matrix(1, 0) / d0;
  const double d1 = matrix(second, second) - factor * (d0 * factor);
  const double rest = (right[second] - factor * right[first]) / d1;
  Eigen::Vector2d solution;
  solution[second] = rest;
  solution[first] = right[first] / d0 - factor * rest;
  return solution;
}

Plane planeThrough(const Moments& m) {
  Plane plane{m.u / m.n, m.v / m.n, m.w / m.n, 0, 0, 0};
  Eigen::Matrix2d spread;
  spread << m.uu - m.u * plane.u0, m.uv - m.u * plane.v0, m.uv - m.u * plane.v0,
      m.vv - m.v * plane.v0;
  spread.diagonal().array() += 1e-3 * m.n;  // one row of pixels has no slope across
  const Eigen::Vector2d pull(m.uw - m.u * plane.w0, m.vw - m.v * plane.w0);
  const Eigen::Vector2d slope = solveSymmetric(spread, pull);
  plane.a = slope.x(), plane.b = slope.y();
  plane.leaves = std::max(0.0, m.ww - m.w * plane.w0 - slope.dot(pull)) / std::max(1.0, m.n - 3);
  return plane;
}

class Blocks {
 public:
  Blocks(const DepthImage& depth, const LabelImage& labels, double sigma)
      : parts_(depth, labels, sigma) {}

  void smooth(DepthImage& depth, const LabelImage& labels, double sigma, double good_m) const {
    const std::optional<double> limit = rangeLimit(depth, sigma);
    for (int y = 0; y < parts_.down(); ++y) {
      for (int x = 0; x < parts_.across(); ++x) {
        for (std::size_t i = parts_.begin(x, y); i < parts_.end(x, y); ++i) {
          const Part part{parts_.label(i), parts_.moments(i)};
          const double inverse = part.moments.w / part.moments.n * sigma;
          if (sigma < good_m * inverse * inverse) continue;
          Plane plane;
          const bool found = findPlane(part, x, y, plane);
          if (limit && !movePast(*limit, part, found, plane))
            forEachPixel(part.label, x, y, labels, depth, [](int, int, float& z) { z = 0; });
          else if (found)
            apply(plane, part.label, x, y, sigma, labels, depth);
        }
      }
    }
  }

 private:
  /// The pixels of one label in a block.
  struct Part {
    std::uint16_t label;
    const Moments& moments;
  };

  Moments window(std::uint16_t label, int x, int y, int radius) const {
    MomentSum sum;
    const int left = std::max(0, x - radius), right = std::min(parts_.across() - 1, x + radius);
    for (int by = std::max(0, y - radius); by <= std::min(parts_.down() - 1, y + radius); ++by) {
      const std::size_t end = parts_.end(right, by);
      for (std::size_t i = parts_.begin(left, by); i < end; ++i)
        if (parts_.label(i) == label) sum.add(parts_.moments(i));
    }
    return sum.total();
  }

  bool findPlane(const Part& part, int x, int y, Plane& plane) const {
    const Moments& own = part.moments;
    for (int radius = kLargest; radius >= 0; --radius) {
      const Moments m = window(part.label, x, y, radius);
      if (m.n < kFewestPixels) return false;
      plane = planeThrough(m);
      const double off = own.w / own.n - plane.at(own.u / own.n, own.v / own.n);
      if (plane.leaves <= kExplained && std::abs(off) <= kMeanError) return true;
    }
    return false;
  }

  /// Moves the plane to where it is if what lies below the limit is not told; false if too much of
  /// it is not.
  static bool movePast(double limit, const Part& part, bool has_plane, Plane& plane) {
    const Moments& own = part.moments;
    const double seen = has_plane ? plane.at(own.u / own.n, own.v / own.n) : own.w / own.n;
    const std::optional<double> all = meanOfAll(seen - limit);
    if (all && has_plane) plane.w0 += limit + *all - seen;
    return all.has_value();
  }

  template <class Change>
  static void forEachPixel(std::uint16_t label, int x, int y, const LabelImage& labels,
                           DepthImage& depth, const Change& change) {
    for (int v = y * kBlock_px; v < std::min((y + 1) * kBlock_px, depth.height); ++v) {
      for (int u = x * kBlock_px; u < std::min((x + 1) * kBlock_px, depth.width); ++u) {
        float& z = depth.at(u, v);
        if (z > 0 && z < 1e9F && labels.at(u, v) == label) change(u, v, z);
      }
    }
  }

  static void apply(const Plane& plane, std::uint16_t label, int x, int y, double sigma,
                    const LabelImage& labels, DepthImage& depth) {
    forEachPixel(label, x, y, labels, depth, [&](int u, int v, float& z) {
      const double w = plane.at(u, v) * sigma;
      if (w > 0) z = static_cast<float>(1 / w);
    });
  }

  BlockMoments parts_;
};

}  // namespace

void smoothDepth(DepthImage& depth, const LabelImage& labels, double inverse_depth_sigma,
                 double good_m) {
  if (inverse_depth_sigma <= 0 || depth.empty()) return;
  Blocks(depth, labels, inverse_depth_sigma).smooth(depth, labels, inverse_depth_sigma, good_m);
}

}  // namespace xview::graph
