// SPDX-License-Identifier: BSD-3-Clause
#include "graph/block_moments.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "graph/point_rows.h"

namespace xview::graph {
namespace {

constexpr int kPixels = kBlock_px * kBlock_px;

/// n, u, v, uu, uv, vv of a pixel of a block, counted from its corner, ten bits each.
constexpr std::uint64_t powersOf(int pixel) {
  const std::uint64_t u = pixel % kBlock_px, v = pixel / kBlock_px;
  return 1 | u << 10 | v << 20 | u * u << 30 | u * v << 40 | v * v << 50;
}
constexpr auto kPowers = [] {
  std::array<std::uint64_t, kPixels> powers{};
  for (int i = 0; i < kPixels; ++i) powers[i] = powersOf(i);
  return powers;
}();
constexpr std::uint64_t kWholePowers = [] {
  std::uint64_t sum = 0;
  for (int i = 0; i < kPixels; ++i) sum += powersOf(i);
  return sum;
}();

/// Whether all pixels of a block are there, measured and of one label, as most are.
bool isOneWhole(const DepthImage& depth, const LabelImage& labels, int left, int top) {
  if (left + kBlock_px > depth.width || top + kBlock_px > depth.height) return false;
  const std::uint64_t four_labels = labels.at(left, top) * 0x0001000100010001ull;
  bool is_one = true, is_measured = true;
  for (int v = top; v < top + kBlock_px; ++v) {
    std::uint64_t four;
    static_assert(sizeof four == kBlock_px * sizeof labels.pixels[0]);
    std::memcpy(&four, &labels.at(left, v), sizeof four);
    is_one &= four == four_labels;
    const float* z = &depth.at(left, v);
    for (int u = 0; u < kBlock_px; ++u) is_measured &= (z[u] > 0) & (z[u] < 1e9F);
  }
  return is_one && is_measured;
}

}  // namespace

BlockMoments::BlockMoments(const DepthImage& depth, const LabelImage& labels, double sigma)
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

/// Measurements of a block, row by row.
struct BlockMoments::Pixels {
  int count = 0;
  std::array<std::uint16_t, kPixels> labels;
  std::array<std::uint8_t, kPixels> place;  ///< row * kBlock_px + column
  std::array<double, kPixels> w;
};

/// `inverse` has the rows of the block, in units of the noise.
void BlockMoments::gather(const DepthImage& depth, const LabelImage& labels,
                          const std::vector<double>& inverse, int left, int top) {
  if (isOneWhole(depth, labels, left, top)) {
    addWhole(labels.at(left, top), inverse.data() + left, depth.width, left, top);
    return;
  }
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

/// What addPart makes of such a block; `inverse` is its first pixel.
void BlockMoments::addWhole(std::uint16_t label, const double* inverse, int stride, int left,
                            int top) {
  double w = 0, uw = 0, vw = 0, ww = 0;
  for (int v = 0; v < kBlock_px; ++v) {
    for (int u = 0; u < kBlock_px; ++u) {
      const double pw = inverse[v * stride + u];
      w += pw;
      uw += (left + u) * pw;
      vw += (top + v) * pw;
      ww += pw * pw;
    }
  }
  append(label, kWholePowers, w, uw, vw, ww, left, top);
}

/// Makes a part of the pixels of `rest` (a bit each) that have the label of the first one.
/// Returns the others.
unsigned BlockMoments::addPart(const Pixels& pixels, int left, int top, unsigned rest) {
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
  append(label, powers, w, uw, vw, ww, left, top);
  return rest;
}

void BlockMoments::append(std::uint16_t label, std::uint64_t powers, double w, double uw, double vw,
                          double ww, int left, int top) {
  const auto sum = [&](int at) { return static_cast<double>(powers >> at & 1023); };
  const double n = sum(0), u = sum(10), v = sum(20), u0 = left, v0 = top;
  labels_.push_back(label);
  moments_.push_back({n, n * u0 + u, n * v0 + v, w, n * u0 * u0 + 2 * u0 * u + sum(30),
                      n * u0 * v0 + u0 * v + v0 * u + sum(40), n * v0 * v0 + 2 * v0 * v + sum(50),
                      uw, vw, ww});
}

}  // namespace xview::graph
