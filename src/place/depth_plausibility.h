// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "place/lift.h"
#include "xview/base/frame.h"
#include "xview/base/semantic_place.h"

namespace xview {

/// Throws Error if ground and houses are curved as if depth were along the ray and not along the
/// axis, or the other way round, and frames agree better that way, too. Some frames of the
/// recording are read.
void requireKindOfDepth(const FrameSource& source);

/// What to type so that a cloud is turned and its lengths are multiplied.
std::string howToMove(const Eigen::Matrix3d& linear);

/// How far the points reach along x, y and z, but for the outermost twentieth on either side [m].
Eigen::Array3d middleReach(const LabelledCloud& cloud);

/// The turn that brings a signed axis (0 = x, 1 = y; sign 1 or -1) to +z.
Eigen::Matrix3d turnUpright(int axis, int sign);

/// Throws Error if a saved cloud is as large as one in millimetres: a place is not kilometres high
/// and measured too thinly to tell any object in it.
void requireMetres(const Frame& frame, const std::string& name);

/// Consistency check: why the lengths of a cloud or graph may not be metres, for a note; a steep
/// place that is sparsely measured may fail it, too.
std::optional<std::string> checkMetres(const Place& place);

/// Consistency check: that x or y and not z may be up in a cloud, for a note. A place reaches less
/// upwards than sideways: the middle nine tenths of the points reach over 30 m along z, and along
/// another axis less than a third of that. A steep cliff may fail it, too.
std::optional<std::string> checkUpright(const Place& place);

/// Watches what became of the measurements of a recording, to name a wrong depth scale, or depth
/// along the ray taken for planar depth, instead of mapping nonsense.
class DepthPlausibility {
 public:
  /// One frame: what lifting counted and kept, where the sensor was in the frame of the cloud, and
  /// how many metres the lengths of both have.
  void add(const LiftCounts& counts, const LabelledCloud& cloud, const Eigen::Vector3d& sensor,
           double metres = 1);

  /// Throws Error
  /// - if next to nothing that was measured is within the range limits;
  /// - if depths are suspiciously small or large and frames contradict one another, while depths
  ///   ten, a hundred or a thousand times as large or small would agree;
  /// - if depths are of the other kind (requireKindOfDepth).
  /// A recording that is merely unusual passes.
  void require(const FrameSource& source) const;

 private:
  LiftCounts counts_;
  std::vector<float> median_ranges_;  ///< of frames
};

}  // namespace xview
