// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "xview/types/frame.h"

namespace xview {

/// Writes a recording as a sequence folder (camera) or a SemanticKITTI folder (LiDAR); frames are
/// read and written on `threads` threads. `truth` (T_map_sensor per frame) goes to groundtruth.txt.
/// Throws Error; a folder that was made for it is then removed again, since a part of a recording
/// would be taken for a whole one. `progress`, if not empty, is called with (done, total).
void writeRecording(const std::string& folder, const FrameSource& source,
                    const std::vector<Eigen::Isometry3d>& truth, int threads,
                    const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace xview
