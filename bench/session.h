// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "xview/io/pose_files.h"
#include "xview/io/recording.h"
#include "xview/mapper.h"
#include "xview/options.h"

namespace xview::bench {

// What most benchmarks begin with: their command line, recordings with true poses, windows of them.

using Flags = std::map<std::string, std::function<void(const std::string& value)>>;

/// The operands. Every word with "--" takes the next one as its value: those in `flags` go there,
/// all others are options. Throws UsageError with `usage` if there are fewer than `least` operands.
std::vector<std::string> parseArguments(int argc, char** argv, const Flags& flags, Options& options,
                                        std::size_t least, const std::string& usage);

/// What stands between commas.
std::vector<std::string> words(const std::string& text);

/// A flag that is a number.
std::function<void(const std::string&)> into(double& number);

/// Of all threads of the process.
double cpuMilliseconds();

/// A recording with its true poses in the map frame.
struct Session {
  std::string name;       ///< of its folder
  bool negative = false;  ///< named elsewhere* or negative*: nothing of it is in the map
  LabelSet labels;
  std::vector<FrameDigest> frames;
  std::vector<double> travelled;       ///< up to each frame [m]
  std::vector<io::StampedPose> truth;  ///< by frame; empty for negatives
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
