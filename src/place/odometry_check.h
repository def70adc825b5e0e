// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/labels.h"
#include "xview/base/semantic_place.h"

namespace xview {

struct Options;
struct PreprocessedFrame;

/// Holds an odometry against the scans. Of each frame it takes what stands (not the ground, which
/// looks alike after any step) and asks how much of it lies where the frame before has seen
/// something, if the sensor moved as the odometry says, as it moved before, or not at all. The
/// odometry jumps where another motion explains clearly more, from one frame to the next or over
/// some metres, or has nearly all points for it that tell both motions apart, where an unusual step
/// leaves much less in place than usual steps do, or any step hardly anything of what is seen all
/// around, where a step is many times the usual one and the scans do not support it, and where the
/// ground leans more and more.
/// What the scans cannot tell, e.g. a small error of length, is no jump. Steps are found in order
/// and the result depends on nothing but the frames.
class OdometryCheck {
 public:
  explicit OdometryCheck(LabelSet labels);
  OdometryCheck(OdometryCheck&&) noexcept;
  OdometryCheck& operator=(OdometryCheck&&) noexcept;
  ~OdometryCheck();

  /// The next frame, at canonical scale. Returns the jump between it and the one before.
  std::optional<OdometryJump> add(const PreprocessedFrame& frame);
  /// Whether the scans support the step to the last frame: the two have enough in common, and most
  /// of that in place. Around a corner a camera sees nothing of what it saw before.
  bool tellsLastStep() const;
  /// What usual steps leave in place, as a share, if that is hardly anything: then no pose is where
  /// its scan was taken.
  std::optional<double> hardlyInPlace() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// All jumps of a recording, whose frames are read and preprocessed for that.
std::vector<OdometryJump> findJumps(const FrameSource& recording, const Options& options);

}  // namespace xview
