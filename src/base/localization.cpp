// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/localization.h"

#include <cmath>

#include "base/pose.h"

namespace xview {

const char* toString(Status status) {
  static constexpr const char* kNames[] = {"accepted", "ambiguous", "rejected"};
  return status <= Status::rejected ? kNames[static_cast<int>(status)] : "?";
}

const char* toString(ReasonCode code) {
  static constexpr const char* kNames[] = {
      "accepted",      "ambiguous",     "out_of_map",    "too_short",        "contradicted",
      "not_converged", "outside_prior", "odometry_jump", "budget_exhausted", "not_comparable"};
  return code <= ReasonCode::not_comparable ? kNames[static_cast<int>(code)] : "?";
}

const char* toString(Proposer proposer) { return proposer == Proposer::walks ? "walks" : "search"; }

double timeOf(const Timings& timings, const std::string& stage) {
  double sum = 0;
  for (const auto& [name, ms] : timings) sum += name == stage ? ms : 0;
  return sum;
}

double totalMs(const Timings& timings) {
  double sum = 0;
  for (const auto& [name, ms] : timings) {
    if (name == "total") return ms;
    sum += ms;
  }
  return sum;
}

bool samePlace(const PlacePose& a, const PlacePose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) <= kSamePlace_m &&
         std::abs(angleDifference(a.yaw, b.yaw)) <= kSamePlace_rad;
}

}  // namespace xview
