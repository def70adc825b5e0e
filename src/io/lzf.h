// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace xview {

/// Undoes the LZF compression of binary_compressed PCD files. True if the input was used up and
/// filled the output exactly; never reads or writes outside.
bool decompressLzf(const unsigned char* input, std::size_t input_bytes, unsigned char* output,
                   std::size_t output_bytes);

/// No LZF stream expands more: three bytes give at most 264.
constexpr std::size_t kLargestLzfExpansion = 88;

}  // namespace xview
