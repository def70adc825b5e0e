// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/mapper.h"
#include "xview/types/frame.h"

namespace xview::tools {

/// Writes a recording as a sequence folder (camera) or a SemanticKITTI folder (LiDAR); frames are
/// read and written on `threads` threads. `truth` (T_map_sensor per frame) goes to groundtruth.txt.
/// Throws Error; a folder that was made for it is then removed again, since a part of a recording
/// would be taken for a whole one.
void writeRecording(const std::string& folder, const FrameSource& source,
                    const std::vector<Eigen::Isometry3d>& truth, int threads,
                    const Progress& progress);

}  // namespace xview::tools
