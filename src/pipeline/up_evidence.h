// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "xview/place_builder.h"

namespace xview {

/// What speaks for a direction of up, from several sources at once.
struct UpEvidence {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  ///< unit vector; zero if nothing tells
  double sigma_rad = 0;                          ///< of its least certain axis
  int grounds = 0, verticals = 0;  ///< frames with a ground plane; pieces of wall and poles
  std::string source;              ///< "ground plane and 31 verticals"
};

/// Up is the normal of the ground classes, on the side of the sensor (or, without a view-point, on
/// the side where things stand), corrected by what stands upright: walls and fences hold no normal
/// that leans, poles lean with nothing. Without ground it is what cameras near the ground and
/// scanners call up.
UpEvidence findUp(const std::vector<PlaceBuilder::SharedDigest>& frames, const LabelSet& labels);

}  // namespace xview
