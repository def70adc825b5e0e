// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "answer.h"

namespace xview::tools {

/// Reads what `xview localize --json` printed, or any file with the same keys; of the fix only
/// status, confidence, the pose and the times. Keys that only xview writes may be missing
/// (Answer::frames is then 0). Throws Error with path:line.
std::vector<Answer> readAnswers(const std::string& path);

}  // namespace xview::tools
