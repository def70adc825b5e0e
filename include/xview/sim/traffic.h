// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "xview/sim/town.h"

namespace xview {

/// Parked cars, people and bicycles of one day; another seed is another day.
TriangleMesh makeTraffic(const Town& town, std::uint64_t day_seed);

}  // namespace xview
