// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "xview/io/pose_files.h"
#include "xview/io/recording.h"
#include "xview/mapper.h"

namespace xview::bench {

/// A recording with its true poses in the map frame.
struct Session {
  std::string name;       ///< of its folder
  bool negative = false;  ///< named elsewhere* or negative*: nothing of it is in the map
  LabelSet labels;
  std::vector<FrameDigest> frames;
  std::vector<double> travelled;   ///< up to each frame [m]
  std::vector<StampedPose> truth;  ///< by frame; empty for negatives
};

/// `word`: a folder, or folder@A:B for a part of it.
std::unique_ptr<FrameSource> openPart(const std::string& word);

/// Frames are digested by `options` on all cores; true poses are in groundtruth.txt or truth.txt.
Session loadSession(const std::string& word, const Options& options);

/// Frames first to last - 1.
struct Window {
  std::size_t first = 0, last = 0;
};

/// Windows of `window_m`, `stride_m` apart, both ends included; the first one also if the session
/// is shorter.
std::vector<Window> windowsOf(const Session& session, double window_m, double stride_m);

}  // namespace xview::bench
