// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "xview/graph/lift.h"
#include "xview/types/frame.h"

namespace xview {

/// Throws Error if ground and houses are curved as if depth were along the ray and not along the
/// axis, or the other way round (curvatureOfPlanes), and frames agree better that way, too. Looks
/// at some frames of the recording.
void requireKindOfDepth(const FrameSource& source);

/// Throws Error if a saved cloud is as large as one in millimetres: a place is not kilometres high
/// and so thinly measured that no thing in it could be told.
void requireMetres(const Frame& frame, const std::string& name);

/// Watches what became of the measurements of a recording, to name a wrong depth scale, or depth
/// along the ray taken for planar depth, instead of mapping nonsense.
class DepthPlausibility {
 public:
  /// One frame: what lifting counted and kept, where the sensor was in the frame of the cloud, and
  /// how many metres the lengths of both have.
  void add(const graph::LiftCounts& counts, const LabelledCloud& cloud,
           const Eigen::Vector3d& sensor, double metres = 1);

  /// Throws Error
  /// - if next to nothing that was measured is within the range limits;
  /// - if depths are suspiciously small or large and frames contradict one another, while depths
  ///   ten, a hundred or a thousand times as large or small would agree (agreementOfDepths);
  /// - if depths are of the other kind (requireKindOfDepth).
  /// A recording that is merely unusual passes.
  void require(const FrameSource& source) const;

 private:
  graph::LiftCounts counts_;
  std::vector<float> median_ranges_;  ///< of frames
};

// Two witnesses of wrong depths that do not know of each other: frames that contradict one another,
// and planes that are bent.

/// What becomes of the pixels of one frame in another one, if depths times a scale and the poses
/// are right.
struct DepthAgreement {
  double visible = 0;   ///< share of the pixels that the other frame should see
  double agreeing = 0;  ///< share of these that it measures there, within 5 %
};

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale);

using FramePair = std::pair<Frame, Frame>;

/// Frames of three places of a recording between which the camera has moved by half a metre or
/// more; fewer where it stood.
std::vector<FramePair> movedPairs(const FrameSource& source);

/// The mean of the pairs.
DepthAgreement agreementOf(const std::vector<FramePair>& pairs, double scale);

/// How bent ground and houses look, 0 = flat. The inverse of planar depth is an affine function of
/// the pixel on every plane, so its second difference over a tenth of the image is zero, but for
/// noise and edges, which the median passes over. With depth along the ray taken for planar depth,
/// or the other way round, it is one or two percent of the inverse depth, all over a frame of 90
/// degrees.
struct PlaneCurvature {
  double as_given = 0;   ///< with depths as the camera declares them
  double otherwise = 0;  ///< with the other kind of depth
};

/// None if too little ground and houses are seen.
std::optional<PlaneCurvature> curvatureOfPlanes(const Frame& frame, const LabelSet& labels);

/// Whether planes of a recording say that depths are of the other kind than its camera declares: as
/// given they are bent by what the two kinds differ in, otherwise they are flat. False if it cannot
/// be told.
bool planesSayOtherKind(const FrameSource& source);

}  // namespace xview
