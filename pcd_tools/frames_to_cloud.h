// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tool.h"
#include "xview/graph/lift.h"
#include "xview/types/frame.h"

namespace xview::tools {

/// The measurements of all frames in the odometry frame, one behind the other. Throws Error if
/// nothing is left.
LabelledCloud liftAll(const FrameSource& source, const Job& job, LiftCounts& counts);

/// Appends a cloud whose origin may differ.
void appendCloud(LabelledCloud& whole, const LabelledCloud& part);

/// Throws UsageError unless the path ends with .pcd or .ply; called before the work, not after it.
void checkCloudEnding(const std::string& path);
/// PCD or PLY by the ending of the path, coloured by class.
void writeCloud(const std::string& path, const LabelledCloud& cloud, const LabelSet& labels);

}  // namespace xview::tools
