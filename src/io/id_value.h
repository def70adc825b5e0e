// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "row_reader.h"

namespace xview {

/// A class or instance id from a number of any type. Negative numbers, and the largest of 32 and 64
/// bit, which is how -1 looks when it was stored unsigned, are 0: none. Fractions, NaN and numbers
/// beyond 32 bit are errors.
std::uint32_t idFromNumber(double value, const Column& column, const RowPlace& place);

}  // namespace xview
