// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "xview/options.h"
#include "xview/place_builder.h"
#include "xview/types/frame.h"

namespace xview {

/// preprocessRecording(), of which the helpers of this process do a part, if there are any. Until
/// it returns they do nothing else.
void preprocessShared(const FrameSource& source, const Options& options,
                      const std::function<void(PreprocessedFrame)>& take);

/// Asks a helper for preprocessFrame() of this frame.
std::string frameRequest(const Frame& frame, const LabelSet& labels, const Options& options);
/// What the helper answers. Throws Error for anything but a frameRequest().
std::string answerFrameRequest(const std::string& request);
/// What it has preprocessed. Throws Error for anything but such an answer.
PreprocessedFrame preprocessedFrameOf(const std::string& answer);

}  // namespace xview
