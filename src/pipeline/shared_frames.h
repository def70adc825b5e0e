// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "xview/options.h"
#include "xview/place_builder.h"
#include "xview/types/frame.h"
#include "xview/types/helpers.h"

namespace xview {

/// The recordings of which a map is made, in the classes of the first, and the options for all.
class MapRecordings {
 public:
  /// Throws as buildMap() does. The sources must outlive this object.
  MapRecordings(const std::vector<const FrameSource*>& sources, const Options& given);

  std::size_t size() const { return in_one_set_.size(); }
  const FrameSource& operator[](std::size_t i) const { return *in_one_set_[i]; }
  const Options& options() const { return options_; }
  std::size_t frames() const;  ///< of all

 private:
  std::vector<std::unique_ptr<const FrameSource>> classified_, in_one_set_;
  Options options_;
};

PreprocessedFrame readAndPreprocess(const FrameSource& source, std::size_t frame,
                                    const Options& options);

/// preprocessRecording() of one of the recordings, by helpers that have them, too.
void preprocessByHelpers(Conversation& helpers, const MapRecordings& recordings, std::size_t which,
                         const std::function<void(PreprocessedFrame)>& take);

/// Asks a helper for a frame of its recordings.
std::string frameRequest(std::size_t recording, std::size_t frame);
/// What the helper answers. Throws Error for anything but a frameRequest().
std::string answerFrameRequest(const std::string& request, const MapRecordings& recordings);
/// What it has preprocessed. Throws Error for anything but such an answer.
PreprocessedFrame preprocessedFrameOf(const std::string& answer);

}  // namespace xview
