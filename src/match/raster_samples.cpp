// SPDX-License-Identifier: BSD-3-Clause
#include "raster_samples.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "xview/types/error.h"

namespace xview::raster {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMaxRadiusCells = 2000;

}  // namespace

double radiusOf(const std::vector<RasterSample>& samples) {
  double radius = 0;
  for (const RasterSample& s : samples) radius = std::max(radius, std::hypot<double>(s.x, s.y));
  return radius;
}

void check(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples) {
  for (const RasterSample& s : samples) {
    if (s.channel >= raster.channels()) {
      throw UsageError("raster search: sample of channel " + std::to_string(s.channel) +
                       ", the raster has " + std::to_string(raster.channels()));
    }
    const double cells = std::hypot<double>(s.x, s.y) / raster.cellSize();
    if (!(cells <= kMaxRadiusCells)) {
      throw UsageError("raster search: a sample is " + std::to_string(cells) +
                       " cells from the centre, at most 2000 are possible; use larger cells");
    }
  }
}

double yawStep(double max_step, double cell_m, double radius_m) {
  return std::min(max_step, 1.2 * cell_m / std::max(10.0, 0.7 * radius_m));
}

YawGrid yawGrid(double wanted_step, const std::optional<PlacePrior::Heading>& prior) {
  if (prior && prior->tolerance < kPi) {
    const int half = static_cast<int>(std::ceil(std::max(0.0, prior->tolerance) / wanted_step));
    const double step = half > 0 ? prior->tolerance / half : wanted_step;
    return {prior->yaw - half * step, step, 2 * half + 1};
  }
  const int count = std::max(1, static_cast<int>(std::ceil(2 * kPi / wanted_step)));
  return {0, 2 * kPi / count, count};
}

PreparedSamples::PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted)
    : samples(std::move(unsorted)) {
  std::stable_sort(
      samples.begin(), samples.end(),
      [](const RasterSample& a, const RasterSample& b) { return a.channel < b.channel; });
  for (const RasterSample& s : samples) {
    if (channels.empty() || channels.back() != s.channel) {
      channels.push_back(s.channel);
      background.push_back(raster.background(s.channel));
      count.push_back(0);
    }
    slot.push_back(static_cast<std::uint32_t>(channels.size() - 1));
    ++count.back();
    background_sum += background.back();
  }
  reach = static_cast<std::int64_t>(std::ceil(radiusOf(samples) / raster.cellSize())) + 1;
}

std::vector<CellOffset> offsetTable(const PreparedSamples& prepared, const YawGrid& grid,
                                    double cell_m) {
  std::vector<CellOffset> table;
  table.reserve(static_cast<std::size_t>(grid.count) * prepared.size());
  const auto cell = [&](double v) {
    return static_cast<std::int32_t>(std::floor(v / cell_m + 0.5 + kRoundingSlack));
  };
  for (int i = 0; i < grid.count; ++i) {
    const double c = std::cos(grid.yaw(i)), s = std::sin(grid.yaw(i));
    for (const RasterSample& q : prepared.samples)
      table.push_back({cell(c * q.x - s * q.y), cell(s * q.x + c * q.y)});
  }
  return table;
}

}  // namespace xview::raster
