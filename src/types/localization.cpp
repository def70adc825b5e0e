// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/localization.h"

#include <cmath>

#include "xview/types/pose.h"

namespace xview {

const char* toString(Status status) {
  static constexpr const char* kNames[] = {"accepted", "ambiguous", "rejected"};
  return status <= Status::rejected ? kNames[static_cast<int>(status)] : "?";
}

const char* toString(Proposer proposer) { return proposer == Proposer::walks ? "walks" : "search"; }

bool samePlace(const PlacePose& a, const PlacePose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) <= kSamePlace_m &&
         std::abs(angleDifference(a.yaw, b.yaw)) <= kSamePlace_rad;
}

}  // namespace xview
