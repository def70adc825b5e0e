// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace xview::verify {

/// Coordinates of points, one array each.
struct PointColumns {
  const double *x, *y, *z;
};

/// Distances of point `at` to all points before it.
void distancesToEarlier(const PointColumns& points, std::size_t at, double* distances);

/// 1 where two distances agree: they differ by at most tolerance + relative * the larger one, and
/// both are at least `least`.
void compareDistances(const double* a, const double* b, std::size_t count, double tolerance,
                      double relative, double least, std::uint8_t* agree);

}  // namespace xview::verify
