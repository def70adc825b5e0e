// SPDX-License-Identifier: BSD-3-Clause
// MCAP bags.
#include "bags.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return xview::fuzz::readBag("in.mcap", data, size);
}
