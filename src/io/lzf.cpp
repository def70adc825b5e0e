// SPDX-License-Identifier: BSD-3-Clause
#include "lzf.h"

#include <cstring>

namespace xview {

// The stream is a sequence of two kinds of items, told apart by their first byte:
//   000LLLLL                       L + 1 bytes follow as they are
//   LLLooooo [llllllll] oooooooo   copy L + 2 bytes from o + 1 bytes back; L = 7 means 7 + l
bool decompressLzf(const unsigned char* input, std::size_t input_bytes, unsigned char* output,
                   std::size_t output_bytes) {
  const unsigned char* const input_end = input + input_bytes;
  std::size_t done = 0;
  while (input < input_end) {
    const std::size_t control = *input++;
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > static_cast<std::size_t>(input_end - input) || length > output_bytes - done)
        return false;
      std::memcpy(output + done, input, length);
      input += length;
      done += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (input == input_end) return false;
      length += *input++;
    }
    length += 2;
    if (input == input_end) return false;
    const std::size_t distance = ((control & 31) << 8) + *input++ + 1;
    if (distance > done || length > output_bytes - done) return false;
    // Byte by byte: the source may overlap what is being written.
    for (std::size_t i = 0; i < length; ++i, ++done) output[done] = output[done - distance];
  }
  return done == output_bytes;
}

}  // namespace xview
