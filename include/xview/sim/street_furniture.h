// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/sim/site.h"

namespace xview {

/// Lamps, utility poles, signs and traffic lights along all streets.
void addStreetFurniture(Site& site, const StreetNetwork& network, std::uint64_t seed);

}  // namespace xview
