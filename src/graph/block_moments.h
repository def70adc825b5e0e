// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/types/image.h"

namespace xview::graph {

constexpr int kBlock_px = 4;

/// Sums over the pixels of one label in a block; w is the inverse depth in units of its noise.
struct Moments {
  double n = 0, u = 0, v = 0, w = 0, uu = 0, uv = 0, vv = 0, uw = 0, vw = 0, ww = 0;
};

/// The moments of the labels in each block of an image. Those of neighbouring blocks lie side by
/// side.
class BlockMoments {
 public:
  /// `sigma` [1/m] is the noise of inverse depth.
  BlockMoments(const DepthImage& depth, const LabelImage& labels, double sigma);

  int across() const { return across_; }  ///< blocks
  int down() const { return down_; }
  /// Parts [begin, end) are those of blocks x0 to x1 of row y.
  std::size_t begin(int x0, int y) const { return first_[y * across_ + x0]; }
  std::size_t end(int x1, int y) const { return first_[y * across_ + x1 + 1]; }
  std::uint16_t label(std::size_t part) const { return labels_[part]; }
  const Moments& moments(std::size_t part) const { return moments_[part]; }

 private:
  struct Pixels;
  void gather(const DepthImage& depth, const LabelImage& labels, const std::vector<double>& inverse,
              int left, int top);
  void addWhole(std::uint16_t label, const double* inverse, int stride, int left, int top);
  unsigned addPart(const Pixels& pixels, int left, int top, unsigned rest);
  void append(std::uint16_t label, std::uint64_t powers, double w, double uw, double vw, double ww,
              int left, int top);

  int across_, down_;
  std::vector<std::uint32_t> first_;   ///< part of each block, and the end
  std::vector<std::uint16_t> labels_;  ///< of the parts
  std::vector<Moments> moments_;
};

}  // namespace xview::graph
