// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "session.h"
#include "xview/types/random.h"

namespace xview::bench {

/// A frame whose odometry frame is another one: T_new_old takes points of the old one to the new.
FrameDigest movedFrame(FrameDigest frame, const Eigen::Isometry3d& T_new_old);

/// A frame of a camera that takes everything for `factor` times as large as it is.
FrameDigest scaledFrame(FrameDigest frame, double factor);

/// A rotation by an angle about any axis.
Eigen::Quaterniond randomTurn(double angle_rad, Random& random);

/// The odometry of a session as it would be with a drift of `share` of the way: steps are too long
/// or too short by a share that changes slowly, and the heading wanders so that after 60 m it is
/// `share` radians off on average. Frames stay as they are in themselves; true poses, too.
void addDrift(Session& session, double share, std::uint64_t seed);

}  // namespace xview::bench
