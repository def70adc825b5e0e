// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "place/recordings_in_one_set.h"
#include "process/helpers.h"
#include "xview/base/frame.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {

PreprocessedFrame readAndPreprocess(const FrameSource& source, std::size_t frame,
                                    const Options& options);

/// preprocessRecording() of one of the recordings, by helpers that have them, too.
void preprocessByHelpers(Conversation& helpers, const RecordingsInOneSet& recordings,
                         std::size_t which, const std::function<void(PreprocessedFrame)>& take);

/// Asks a helper for a frame of its recordings.
std::string frameRequest(std::size_t recording, std::size_t frame);
/// What the helper answers. Throws Error for anything but a frameRequest().
std::string answerFrameRequest(const std::string& request, const RecordingsInOneSet& recordings);
/// What it has preprocessed. Throws Error for anything but such an answer.
PreprocessedFrame preprocessedFrameOf(const std::string& answer);

}  // namespace xview
