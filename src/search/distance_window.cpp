// SPDX-License-Identifier: BSD-3-Clause
#include "search/distance_window.h"

#include <algorithm>
#include <cmath>

namespace xview::search {
namespace {

// Compiled with -O3 -ffp-contract=off: vectors of any width, but the same roundings with all of
// them.
#define XVIEW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

constexpr int kSide = DistanceWindow::kSide;
constexpr float kNowhere = -1e6f;      ///< coordinate of the site of a cell that has none
constexpr float kFar = 1e9f;           ///< squared distance where there is no site
constexpr std::size_t kFewSites = 48;  ///< so many cost as much as handing on

float squaredDistance(float dx, float dy) { return dx * dx + dy * dy; }

/// Lowers the distances of the cells to those to one site.
XVIEW_CLONES void tryOneSite(DistanceWindow::Site site, int first_row, int last_row,
                             float* squared) {
  float across[kSide];
  for (int x = 0; x < kSide; ++x) {
    const float dx = static_cast<float>(x) + 0.5f - site.x;
    across[x] = dx * dx;
  }
  for (int y = first_row; y < last_row; ++y) {
    const float dy = static_cast<float>(y) + 0.5f - site.y, dy_squared = dy * dy;
    float* row = squared + y * kSide;
    for (int x = 0; x < kSide; ++x) {
      const float d = across[x] + dy_squared;
      row[x] = d < row[x] ? d : row[x];
    }
  }
}

/// Each line takes the nearer sites of the line before it, of the same cell and the two beside it:
/// a site comes to all cells that see it within 45 degrees of the direction of travel. `margin`:
/// coordinate 0 of the lines.
XVIEW_CLONES void handOn(float* along, float* across, int stride, int width, int margin, int first,
                         int last, int step) {
  for (int line = first; line != last; line += step) {
    const float line_centre = static_cast<float>(line - margin) + 0.5f;
    const float* __restrict from_along = along + (line - step) * stride;
    const float* __restrict from_across = across + (line - step) * stride;
    float* __restrict own_along = along + line * stride;
    float* __restrict own_across = across + line * stride;
    for (int i = 1; i <= width; ++i) {
      const float centre = static_cast<float>(i - 1 - margin) + 0.5f;
      float a = own_along[i], c = own_across[i];
      float best = squaredDistance(centre - a, line_centre - c);
      for (int k = -1; k <= 1; ++k) {
        const float other_a = from_along[i + k], other_c = from_across[i + k];
        const float d = squaredDistance(centre - other_a, line_centre - other_c);
        const bool nearer = d < best;
        a = nearer ? other_a : a;
        c = nearer ? other_c : c;
        best = nearer ? d : best;
      }
      own_along[i] = a;
      own_across[i] = c;
    }
  }
}

XVIEW_CLONES void measure(const float* along, const float* across, float line_centre,
                          float* squared) {
  for (int i = 0; i < kSide; ++i) {
    squared[i] = squaredDistance(static_cast<float>(i) + 0.5f - along[i], line_centre - across[i]);
  }
}

XVIEW_CLONES void addReached(const float* __restrict squared, float limit,
                             std::uint8_t* __restrict counts) {
  for (int i = 0; i < kSide * kSide; ++i) {
    counts[i] = static_cast<std::uint8_t>(counts[i] + (squared[i] >= limit));
  }
}

}  // namespace

DistanceWindow::DistanceWindow(float reach)
    : reach_(reach),
      margin_(static_cast<int>(std::ceil(reach))),
      width_(kSide + 2 * margin_),
      stride_((width_ + 2 + 15) / 16 * 16) {}

void DistanceWindow::placeSites(const std::vector<Site>& sites) {
  const auto cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(stride_);
  for (Lines* lines : {&rows_, &columns_}) {
    lines->along.assign(cells, kNowhere);
    lines->across.assign(cells, kNowhere);
  }
  for (const Site& s : sites) {
    const int x = static_cast<int>(std::floor(s.x)) + margin_,
              y = static_cast<int>(std::floor(s.y)) + margin_;
    if (x < 0 || y < 0 || x >= width_ || y >= width_) continue;
    const int in_rows = y * stride_ + x + 1, in_columns = x * stride_ + y + 1;
    if (rows_.along[in_rows] != kNowhere) {
      tryOneSite(s, 0, kSide, squared_.data());
      continue;
    }
    rows_.along[in_rows] = columns_.across[in_columns] = s.x;
    rows_.across[in_rows] = columns_.along[in_columns] = s.y;
  }
}

void DistanceWindow::takeFrom(const Lines& lines, bool transposed) {
  float line[kSide];
  for (int i = 0; i < kSide; ++i) {
    const int first = (i + margin_) * stride_ + margin_ + 1;
    measure(lines.along.data() + first, lines.across.data() + first, static_cast<float>(i) + 0.5f,
            line);
    for (int k = 0; k < kSide; ++k) {
      float& squared =
          squared_[static_cast<std::size_t>(transposed ? k * kSide + i : i * kSide + k)];
      squared = std::min(squared, line[k]);
    }
  }
}

void DistanceWindow::countReached(const Distances& squared, const std::vector<float>& limits,
                                  std::uint8_t* counts) {
  std::fill(counts, counts + squared.size(), std::uint8_t{0});
  for (const float limit : limits) addReached(squared.data(), limit, counts);
}

const DistanceWindow::Distances& DistanceWindow::squared(const std::vector<Site>& sites) {
  squared_.fill(kFar);
  if (sites.size() <= kFewSites) {
    for (const Site& s : sites) {
      tryOneSite(s, std::max(0, static_cast<int>(s.y - reach_) - 1),
                 std::min(kSide, static_cast<int>(s.y + reach_) + 1), squared_.data());
    }
    return squared_;
  }
  placeSites(sites);
  for (Lines* lines : {&rows_, &columns_}) {
    handOn(lines->along.data(), lines->across.data(), stride_, width_, margin_, 1, margin_ + kSide,
           1);
    handOn(lines->along.data(), lines->across.data(), stride_, width_, margin_, width_ - 2,
           margin_ - 1, -1);
    takeFrom(*lines, lines == &columns_);
  }
  return squared_;
}

}  // namespace xview::search
