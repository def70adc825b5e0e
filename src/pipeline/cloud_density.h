// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/types/labelled_cloud.h"

namespace xview {

/// For each voxel of a cloud whose ranges are not known, the share of its votes that it keeps, in
/// [0, 1]. What was measured from afar is sparse, and if it was measured badly as well it is
/// scattered: where surfaces are thicker than those of a scanner, voxels lose votes by the square
/// of how much fewer points lie around them than usual, as if by the square of the range. Clouds
/// with sharp surfaces keep all. `voxels`: one point per voxel and class; `points`: in each voxel.
std::vector<float> trustByDensity(const LabelledCloud& voxels,
                                  const std::vector<std::uint32_t>& points, double voxel_m);

}  // namespace xview
