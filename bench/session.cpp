// SPDX-License-Identifier: BSD-3-Clause
#include "session.h"

#include <time.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "xview/options_file.h"
#include "xview/types/error.h"

namespace xview::bench {
namespace {

std::string folderOf(const std::string& word) { return word.substr(0, word.rfind('@')); }

std::string truthFileOf(const std::string& folder) {
  const std::string file = folder + "/groundtruth.txt";
  return std::filesystem::exists(file) ? file : folder + "/truth.txt";
}

}  // namespace

std::vector<std::string> parseArguments(int argc, char** argv, const Flags& flags, Options& options,
                                        std::size_t least, const std::string& usage) {
  std::vector<std::string> operands;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      operands.push_back(word);
      continue;
    }
    if (++i == argc) throw UsageError(word + " needs a value");
    const auto flag = flags.find(word);
    if (flag == flags.end())
      setOption(options, word.substr(2), argv[i]);
    else
      flag->second(argv[i]);
  }
  if (operands.size() < least) throw UsageError("usage: " + usage);
  return operands;
}

std::function<void(const std::string&)> into(double& number) {
  return [&number](const std::string& value) { number = std::stod(value); };
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) list.push_back(word);
  return list;
}

double cpuMilliseconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

std::unique_ptr<FrameSource> openPart(const std::string& word) {
  io::InputOptions input;
  const std::size_t at = word.rfind('@');
  if (at != std::string::npos) input.frames = io::parseFrameRange(word.substr(at + 1));
  return io::openRecording(folderOf(word), input);
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
  if (!s.negative) s.truth = io::posesOfFrames(truthFileOf(folder), numbers);
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
