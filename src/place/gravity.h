// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "base/stored_vertices.h"
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
UpEvidence findUp(const std::vector<PlaceBuilder::SharedFrame>& frames, const LabelSet& labels);

/// Which way is up in the frame of a recording, by options.gravity: `aligned` believes in z; `auto`
/// does so unless what was measured (see findUp) is clearly off, as most odometry frames are
/// gravity-aligned and streets may be steep; `free` takes what was measured. If nothing tells, auto
/// believes in z and free knows nothing.
Gravity gravityOf(const std::vector<PlaceBuilder::SharedFrame>& frames, const LabelSet& labels,
                  const std::string& mode);

/// The same for a bare graph. What stands in a street forms a flat layer, class by class; which
/// side of it is up is told by classes of ground that lie below the others. Not known if the layer
/// is tilted and no class tells.
Gravity gravityOf(const AllVertices& vertices, const LabelSet& labels, const std::string& mode);

/// That of a view, which was drawn upright.
Gravity gravityOf(const BevGrid& view);
/// That of a saved place: a BEV grid was drawn upright, a bare graph is what it is.
Gravity gravityOf(const Place& place, const std::string& mode);

/// The normal of the layer of a graph, without its side; zero if it is no layer.
Eigen::Vector3d layerNormal(const AllVertices& vertices);

/// The smallest rotation that takes `up` to z.
Eigen::Quaterniond alignmentFromUp(const Eigen::Vector3d& up);

}  // namespace xview
