// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/smooth_depth.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "range_limit.h"
#include "row_loops.h"

namespace xview {
namespace {

constexpr int kBlock_px = 4;
constexpr int kLargest = 2;           ///< blocks to each side of a window
constexpr double kFewestPixels = 12;  ///< of a window
constexpr double kExplained = 1.4;    ///< times the noise, squared: what a plane may leave
constexpr double kMeanError = 1.2;    ///< times the noise: what the mean of one block may be off

/// Sums over the pixels of one label in a block; w is the inverse depth in units of its noise.
struct Moments {
  double n = 0, u = 0, v = 0, w = 0, uu = 0, uv = 0, vv = 0, uw = 0, vw = 0, ww = 0;
};

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
      : across_((depth.width + kBlock_px - 1) / kBlock_px),
        down_((depth.height + kBlock_px - 1) / kBlock_px) {
    const std::size_t blocks = static_cast<std::size_t>(across_) * down_;
    first_.reserve(blocks + 1);
    labels_.reserve(blocks + blocks / 2);
    moments_.reserve(blocks + blocks / 2);
    first_.push_back(0);
    std::vector<double> inverse(static_cast<std::size_t>(depth.width) * kBlock_px);
    for (int y = 0; y < down_; ++y) {
      const int top = y * kBlock_px, rows = std::min(kBlock_px, depth.height - top);
      invertDepths(&depth.at(0, top), static_cast<std::size_t>(depth.width) * rows, sigma,
                   inverse.data());
      for (int x = 0; x < across_; ++x) {
        gather(depth, labels, inverse, x * kBlock_px, top);
        first_.push_back(static_cast<std::uint32_t>(labels_.size()));
      }
    }
  }

  void smooth(DepthImage& depth, const LabelImage& labels, double sigma, double good_m) const {
    const std::optional<double> limit = rangeLimit(depth, sigma);
    for (int y = 0; y < down_; ++y) {
      for (int x = 0; x < across_; ++x) {
        for (std::size_t i = first_[y * across_ + x]; i < first_[y * across_ + x + 1]; ++i) {
          const Part part{labels_[i], moments_[i]};
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
  static constexpr int kPixels = kBlock_px * kBlock_px;

  /// The pixels of one label in a block.
  struct Part {
    std::uint16_t label;
    const Moments& moments;
  };

  /// Measurements of a block, row by row.
  struct Pixels {
    int count = 0;
    std::array<std::uint16_t, kPixels> labels;
    std::array<std::uint8_t, kPixels> place;  ///< row * kBlock_px + column
    std::array<double, kPixels> w;
  };

  /// `inverse` has the rows of the block, in units of the noise.
  void gather(const DepthImage& depth, const LabelImage& labels, const std::vector<double>& inverse,
              int left, int top) {
    const int right = std::min(left + kBlock_px, depth.width);
    const int bottom = std::min(top + kBlock_px, depth.height);
    Pixels pixels;
    for (int v = top; v < bottom; ++v) {
      const float* z = &depth.at(left, v);
      const std::uint16_t* label = &labels.at(left, v);
      const double* w = &inverse[static_cast<std::size_t>(v - top) * depth.width + left];
      for (int u = left; u < right; ++u, ++z, ++label, ++w) {
        if (!(*z > 0 && *z < 1e9F)) continue;
        pixels.labels[pixels.count] = *label;
        pixels.place[pixels.count] = static_cast<std::uint8_t>((v - top) * kBlock_px + u - left);
        pixels.w[pixels.count++] = *w;
      }
    }
    for (unsigned rest = (1u << pixels.count) - 1; rest != 0;)
      rest = addPart(pixels, left, top, rest);
  }

  /// Sums of n, u, v, uu, uv, vv of one pixel within the block, ten bits each.
  static constexpr std::uint64_t packedPowers(int place) {
    const std::uint64_t u = place % kBlock_px, v = place / kBlock_px;
    return 1 | u << 10 | v << 20 | u * u << 30 | u * v << 40 | v * v << 50;
  }

  /// Makes a part of the pixels of `rest` (a bit each) that have the label of the first one.
  /// Returns the others.
  unsigned addPart(const Pixels& pixels, int left, int top, unsigned rest) {
    static constexpr auto kPowers = [] {
      std::array<std::uint64_t, kPixels> powers{};
      for (int i = 0; i < kPixels; ++i) powers[i] = packedPowers(i);
      return powers;
    }();
    const int first = __builtin_ctz(rest);
    const std::uint16_t label = pixels.labels[first];
    std::uint64_t powers = 0;
    double w = 0, uw = 0, vw = 0, ww = 0;
    for (int i = first; i < pixels.count; ++i) {
      if (pixels.labels[i] != label) continue;
      rest &= ~(1u << i);
      const int place = pixels.place[i];
      powers += kPowers[place];
      const double pw = pixels.w[i];
      w += pw;
      uw += (left + place % kBlock_px) * pw;
      vw += (top + place / kBlock_px) * pw;
      ww += pw * pw;
    }
    const auto sum = [&](int at) { return static_cast<double>(powers >> at & 1023); };
    const double n = sum(0), u = sum(10), v = sum(20), u0 = left, v0 = top;
    labels_.push_back(label);
    moments_.push_back({n, n * u0 + u, n * v0 + v, w, n * u0 * u0 + 2 * u0 * u + sum(30),
                        n * u0 * v0 + u0 * v + v0 * u + sum(40), n * v0 * v0 + 2 * v0 * v + sum(50),
                        uw, vw, ww});
    return rest;
  }

  Moments window(std::uint16_t label, int x, int y, int radius) const {
    MomentSum sum;
    const int left = std::max(0, x - radius), right = std::min(across_ - 1, x + radius);
    for (int by = std::max(0, y - radius); by <= std::min(down_ - 1, y + radius); ++by) {
      // the parts of neighbouring blocks lie side by side
      const std::size_t end = first_[by * across_ + right + 1];
      for (std::size_t i = first_[by * across_ + left]; i < end; ++i)
        if (labels_[i] == label) sum.add(moments_[i]);
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

  int across_, down_;
  std::vector<std::uint32_t> first_;   ///< part of each block, and the end
  std::vector<std::uint16_t> labels_;  ///< of the parts
  std::vector<Moments> moments_;
};

}  // namespace

void smoothDepth(DepthImage& depth, const LabelImage& labels, double inverse_depth_sigma,
                 double good_m) {
  if (inverse_depth_sigma <= 0 || depth.empty()) return;
  Blocks(depth, labels, inverse_depth_sigma).smooth(depth, labels, inverse_depth_sigma, good_m);
}

}  // namespace xview
