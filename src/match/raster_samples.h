// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "xview/match/raster_search.h"

namespace xview::raster {

/// Largest distance of a sample from the centre [m].
double radiusOf(const std::vector<RasterSample>& samples);

/// Throws UsageError for samples that cannot be looked up.
void check(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples);

/// Evenly spaced headings: the circle, or the tolerance around the expected one.
struct YawGrid {
  double first = 0, step = 0;
  int count = 0;
  double yaw(int index) const { return first + index * step; }
};

/// A sample at 70 % of the query radius moves by at most 1.2 cells from one heading to the next.
double yawStep(double max_step, double cell_m, double radius_m);
YawGrid yawGrid(double wanted_step, const std::optional<PlacePrior::Heading>& prior);

/// Samples sorted by channel, with the channels that occur numbered densely.
struct PreparedSamples {
  std::vector<RasterSample> samples;
  std::vector<std::uint16_t> channels;   ///< the different ones, rising
  std::vector<std::uint32_t> slot;       ///< per sample: index of its channel in `channels`
  std::vector<std::uint32_t> count;      ///< per slot: number of samples
  std::vector<std::uint8_t> background;  ///< per slot
  std::int64_t background_sum = 0;       ///< over samples
  std::int64_t reach = 0;                ///< largest possible offset [cells]

  PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted);
  std::size_t size() const { return samples.size(); }
};

/// The cell of a sample relative to the cell of the query centre.
struct CellOffset {
  std::int32_t x, y;
};

/// All offsets, heading by heading.
std::vector<CellOffset> offsetTable(const PreparedSamples& prepared, const YawGrid& grid,
                                    double cell_m);

constexpr double kRoundingSlack =
    1e-6;  ///< [cells] makes exact halves round up in spite of rounding errors

}  // namespace xview::raster
