// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1.
#include "bags.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return xview::fuzz::readBag("in.bag", data, size);
}
