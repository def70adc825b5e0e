// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/graph/lift.h"

namespace xview {

/// Which points of a frame are wanted besides the thinned ones.
enum class WholeClasses { none, no_surfaces, all };

/// A frame as mapping needs it.
struct ThinFrame {
  LabelledCloud thin;  ///< all points, thinned by voxel
  std::vector<std::uint32_t> points_per_voxel;
  LabelledCloud whole;     ///< the points of the classes that were asked for, as they are
  bool is_aerial = false;  ///< a camera, and the nearest tenth of its points is over 15 m away
};

/// thinByVoxel(lift(frame), voxel_m) in one go, without all points in memory: the same results.
ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts = nullptr);

}  // namespace xview
