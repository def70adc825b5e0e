// SPDX-License-Identifier: BSD-3-Clause
#include "base64.h"

#include <cstdint>

namespace xview {

std::string base64(const void* data, std::size_t size) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t present = size - i < 3 ? size - i : 3;
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8) | (k < present ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= present ? kLetters[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

}  // namespace xview
