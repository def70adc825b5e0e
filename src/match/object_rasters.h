// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "object_map.h"

namespace xview {

/// Steps of a raster byte per nat of evidence, and the largest byte.
constexpr double kRasterStepsPerNat = 3;
constexpr int kHighestRasterValue = 15;

/// Neighbouring samples of a surface are one piece of evidence per cell at most: the query is
/// thinned to that for the search. One channel per class slot: how much more likely a query vertex
/// of that class is here, compared to where the map has nothing.
LikelihoodRaster rasterizeObjects(const ObjectMap& map, const ObjectPlaceOptions& options,
                                  double cell_m);

}  // namespace xview
