// SPDX-License-Identifier: BSD-3-Clause
// Databases of rosbag2.
#include "bags.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return xview::fuzz::readBag("in.db3", data, size);
}
