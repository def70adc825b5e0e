// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "xview/types/labelled_cloud.h"

namespace xview {

/// Angles between neighbouring measurements of a spinning scanner.
struct BeamSpacing {
  double azimuth_rad = 0;    ///< of one beam, from measurement to measurement
  double elevation_rad = 0;  ///< between two beams
  bool isKnown() const { return azimuth_rad > 0 && elevation_rad > 0; }
};

/// The spacing of the beams that measured these points around the origin of their frame, or nothing
/// if they are no scan: in narrow sectors of a scan the elevations come in steps, those of a cloud
/// from many places do not. The order of the points does not matter. Rings (the beam of each point)
/// are used if there are any and if they lie at elevations of their own, but they are not needed.
BeamSpacing measureBeamSpacing(const LabelledCloud& cloud,
                               const std::vector<std::uint16_t>& rings = {});

/// How a cloud was scanned.
struct ScanView {
  Eigen::Isometry3d T_cloud_sensor =
      Eigen::Isometry3d::Identity();  ///< sensor in the cloud's frame
  BeamSpacing beams;
};

/// Joins clusters (numbers from 0, or -1) whose points lie next to one another in the range image:
/// at most two beams apart, one of them lost, upwards and sideways, and at most `depth_m` in range.
/// `points` are in the frame of the sensor; only those further away than `depth_m` over the spacing
/// are looked at, because a tolerance of `depth_m` has joined the others already.
void joinAlongBeams(const std::vector<Eigen::Vector3f>& points, const BeamSpacing& beams,
                    float depth_m, std::vector<int>& cluster_of_point);

/// How many points of a thin post a scan holds at that range, at most `most` and at least a few.
int pointsOfThinThing(double range_m, const BeamSpacing& beams, int most);

}  // namespace xview
