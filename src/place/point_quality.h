// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/place_builder.h"

namespace xview {

// How well points are known, and which of them are worth keeping.

/// Distance of a point of a frame from the sensor [m]; 0 for clouds, which do not tell it.
float rangeOf(const PreprocessedFrame& frame, std::size_t i);

/// Adds the points of another cloud of the same frame whose positions are known well enough, as
/// seen from the pose with that number. Returns how many.
std::size_t appendKnownPoints(const LabelledCloud& addition, double max_sigma_m, std::uint32_t view,
                              LabelledCloud& cloud);

/// Which points to keep where things were seen from afar and from near: those that are known about
/// as well as the best ones of their class around them (cells of 1.5 m). Depth errors of stereo
/// grow with the square of the range, and smear a thing along the rays to it. What is good to 0.1 m
/// is kept anywhere.
std::vector<bool> bestMeasured(const LabelledCloud& cloud);
void keepBestMeasured(LabelledCloud& cloud);

/// Leaves out points whose label contradicts their height above the ground that a BEV grid of the
/// same frame measured: things that lie on it, and ground that lies far above it. Where labels err,
/// patches of ground would stand in the way as things. The feet of walls that were measured too low
/// go as well, which costs less than to keep all points that are not known to 0.2 m.
void dropContradicted(const BevGrid& bev, const LabelSet& labels, LabelledCloud& cloud);

/// For each voxel of a cloud whose ranges are not known, the share of its weights that it keeps, in
/// [0, 1]. What was measured from afar is sparse, and if it was measured badly as well it is
/// scattered: where surfaces are thicker than those of a scanner, voxels lose weights by the square
/// of how much fewer points lie around them than usual, as if by the square of the range. Clouds
/// with sharp surfaces keep all. `voxels`: one point per voxel and class; `points`: in each voxel.
std::vector<float> densityWeights(const LabelledCloud& voxels,
                                  const std::vector<std::uint32_t>& points, double voxel_m);

/// Whether most voxels of a cloud hold a single measurement and lie apart from one another: then
/// one measurement is as good as it gets.
bool isSparse(const LabelledCloud& voxels, const std::vector<std::uint32_t>& points,
              double voxel_m);

}  // namespace xview
