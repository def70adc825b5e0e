// SPDX-License-Identifier: BSD-3-Clause
#include "verify/distance_agreement.h"

#include <cmath>

namespace xview::verify {

// Compiled with -O3 -ffp-contract=off: vectors of any width, but the same roundings with all of
// them.
#define XVIEW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

XVIEW_CLONES void distancesToEarlier(const PointColumns& points, std::size_t at,
                                     double* __restrict distances) {
  const double* __restrict x = points.x, * __restrict y = points.y, * __restrict z = points.z;
  const double ax = x[at], ay = y[at], az = z[at];
  for (std::size_t i = 0; i < at; ++i) {
    const double dx = x[i] - ax, dy = y[i] - ay, dz = z[i] - az;
    distances[i] = std::sqrt(dx * dx + dy * dy + dz * dz);
  }
}

XVIEW_CLONES void compareDistances(const double* __restrict a, const double* __restrict b,
                                   std::size_t count, double tolerance, double relative,
                                   double least, std::uint8_t* __restrict agree) {
  for (std::size_t i = 0; i < count; ++i) {
    const double larger = a[i] > b[i] ? a[i] : b[i], smaller = a[i] > b[i] ? b[i] : a[i];
    agree[i] = static_cast<std::uint8_t>((larger - smaller <= tolerance + relative * larger) &
                                         (smaller >= least));
  }
}

}  // namespace xview::verify
