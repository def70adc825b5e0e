// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "eval/evaluation.h"
#include "narrative.h"

namespace xview::tools {

/// Results beside the truth of their queries: answers of localize --json, or a trajectory, whose
/// poses are answers that were accepted without saying how sure they are. What has no true pose is
/// left out with a note. Throws Error that names the file.
std::vector<ScoredQuery> scoredFile(const std::string& results, const std::string& truth,
                                    const Narrative& narrate);

/// True if the file holds poses, not answers of localize --json.
bool isTrajectory(const std::string& path);

/// A pose that was accepted without saying how sure it is.
Localization acceptedPose(const Eigen::Isometry3d& T_map_sensor);

}  // namespace xview::tools
