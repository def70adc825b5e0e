// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/base/labelled_cloud.h"

namespace xview::test {

inline std::vector<std::uint32_t> instancesOf(const LabelledCloud& cloud) {
  std::vector<std::uint32_t> instances;
  for (const Point& p : cloud.points) instances.push_back(p.instance);
  return instances;
}

}  // namespace xview::test
