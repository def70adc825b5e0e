// SPDX-License-Identifier: BSD-3-Clause
#include "session.h"

#include <algorithm>
#include <filesystem>

namespace xview::bench {
namespace {

std::string folderOf(const std::string& word) { return word.substr(0, word.rfind('@')); }

std::string truthFileOf(const std::string& folder) {
  const std::string file = folder + "/groundtruth.txt";
  return std::filesystem::exists(file) ? file : folder + "/truth.txt";
}

}  // namespace

std::unique_ptr<FrameSource> openPart(const std::string& word) {
  InputOptions input;
  const std::size_t at = word.rfind('@');
  if (at != std::string::npos) input.frames = parseFrameRange(word.substr(at + 1));
  return openRecording(folderOf(word), input);
}

Session loadSession(const std::string& word, const Options& options) {
  const std::string folder = folderOf(word);
  Session s;
  s.name = std::filesystem::path(folder).filename().string();
  s.negative = s.name.find("elsewhere") != std::string::npos || s.name.rfind("negative", 0) == 0;
  const auto source = openPart(word);
  Options parallel = options;
  parallel.threads = 0;
  s.frames = digestRecording(*source, parallel);
  s.labels = source->labels();
  std::vector<std::int64_t> numbers;
  double way = 0;
  for (std::size_t i = 0; i < s.frames.size(); ++i) {
    numbers.push_back(s.frames[i].number);
    if (i > 0) {
      way += (s.frames[i].T_odom_sensor.translation() - s.frames[i - 1].T_odom_sensor.translation())
                 .norm();
    }
    s.travelled.push_back(way);
  }
  if (!s.negative) s.truth = posesOfFrames(truthFileOf(folder), numbers);
  return s;
}

std::vector<Window> windowsOf(const Session& s, double window_m, double stride_m) {
  const std::vector<double>& t = s.travelled;
  std::vector<Window> windows;
  for (double from = 0; from == 0 || from + window_m <= t.back() + 1; from += stride_m) {
    const auto first = std::lower_bound(t.begin(), t.end(), from) - t.begin();
    const auto last = std::upper_bound(t.begin(), t.end(), from + window_m) - t.begin();
    const auto begin = static_cast<std::size_t>(first);
    const Window window{begin, std::max(begin + 1, static_cast<std::size_t>(last))};
    if (windows.empty() || windows.back().first != window.first) windows.push_back(window);
  }
  return windows;
}

}  // namespace xview::bench
