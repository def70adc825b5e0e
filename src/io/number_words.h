// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace xview {

/// The whole word as a number, whatever the locale; "nan" and "inf" are numbers, too.
std::optional<double> asNumber(std::string_view word);
std::optional<std::int64_t> asInteger(std::string_view word);

}  // namespace xview
