// SPDX-License-Identifier: BSD-3-Clause
#include "id_value.h"

#include <charconv>
#include <cmath>

namespace xview {

std::uint32_t idFromNumber(double value, const Column& column, const RowPlace& place) {
  constexpr double kMinusOne32 = 4294967295.0;
  constexpr double kMinusOne64 = 0x1p64;  // 2^64 - 1 as a double
  if (value == kMinusOne32 || (value == kMinusOne64 && column.type == ScalarType::u64)) return 0;
  const bool whole = std::isfinite(value) && value == std::floor(value);
  if (whole && value < 0) return 0;
  if (!whole || value > kMinusOne32) {
    char text[32];
    const char* end = std::to_chars(text, text + sizeof(text), value).ptr;
    place.fail(quoted(column.name) + " must be a whole number below 2^32, found " +
               std::string(text, static_cast<std::size_t>(end - text)));
  }
  return static_cast<std::uint32_t>(value);
}

}  // namespace xview
