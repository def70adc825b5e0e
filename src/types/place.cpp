// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/place.h"

#include <cmath>

#include "xview/types/pose.h"

namespace xview {

bool samePlace(const PlacePose& a, const PlacePose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) <= kSamePlace_m &&
         std::abs(angleDifference(a.yaw, b.yaw)) <= kSamePlace_rad;
}

}  // namespace xview
