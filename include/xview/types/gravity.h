// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>

namespace xview {

/// Which way is up in a frame, and how that is known.
struct Gravity {
  bool known = true;  ///< false: nothing tells; poses of this frame have six degrees of freedom
  Eigen::Quaterniond upright =
      Eigen::Quaterniond::Identity();  ///< turns the frame so that z points up
  double sigma_rad = 0;  ///< error of that; 0 = z is up by the word of whoever made the frame
  std::string reason = "z is up as given";

  bool turned() const { return upright.angularDistance(Eigen::Quaterniond::Identity()) > 0; }
};

/// How many degrees of freedom an answer was looked for with.
enum class GravityUse {
  aligned,   ///< x, y, z and heading: z is up in map and query as they are
  levelled,  ///< the same after one of them was turned to stand upright
  free       ///< six: the pose itself says which way is up
};

inline const char* toString(GravityUse use) {
  return use == GravityUse::aligned ? "aligned" : use == GravityUse::levelled ? "levelled" : "free";
}

}  // namespace xview
