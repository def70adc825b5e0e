// SPDX-License-Identifier: BSD-3-Clause
#include "queries.h"

#include <fmt/core.h>

#include <algorithm>

#include "recording_part.h"
#include "xview/depth_plausibility.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

/// Position of the first frame that is at most so many metres of travel before the last one.
std::size_t firstWithin(const FrameSource& source, double length_m) {
  std::size_t first = source.size();
  double travelled = 0;
  while (first > 1 && travelled <= length_m) {
    --first;
    travelled += (source.pose(first).translation() - source.pose(first - 1).translation()).norm();
  }
  return travelled > length_m ? first : 0;
}

/// What is known of the frames before they are read.
std::vector<FrameDigest> unreadFrames(const FrameSource& source) {
  std::vector<FrameDigest> frames(source.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].number = source.number(i);
    frames[i].stamp_s = source.stamp(i);
    frames[i].sensor = source.sensor();
    frames[i].T_odom_sensor = source.pose(i);
  }
  return frames;
}

void readWhole(const FrameSource& source, double last_m, const Job& job, QueryInput& result) {
  result.frames = unreadFrames(source);
  result.used_from = last_m > 0 ? firstWithin(source, last_m) : 0;
  if (result.used_from > 0)
    job.narrate.note(
        fmt::format("{}: its last {:g} m tell where it ends (--last)", source.name(), last_m));
  const RecordingPart used(source, result.used_from);
  const Progress progress = job.narrate.progress("frames");
  FrameTally tally;
  Stopwatch watch;
  result.whole =
      std::make_unique<Query>(makeQuery(used, job.options, [&](const FrameDigest& frame) {
        tally.add(frame);
        if (progress) progress(tally.frames(), used.size());
      }));
  tally.say(source.name(), watch.lap_ms(), job.narrate);
}

}  // namespace

QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels, const WindowFlags& windows) {
  QueryInput result;
  result.path = path;
  const InputOptions options = inputIn(input, map_labels);
  switch (recogniseInput(path, options)) {
    case InputKind::map:
      result.whole = std::make_unique<Query>(makeQuery(loadMap(path), job.options));
      result.labels = result.whole->labels;
      break;
    case InputKind::graph: {
      LabelledGraph file = readLabelledGraph(path, options, job.options);
      result.labels = std::move(file.labels);
      result.whole = std::make_unique<Query>(makeQuery(file.graph, result.labels, job.options));
      break;
    }
    default: {
      std::unique_ptr<FrameSource> source = openInput(path, options, job);
      result.labels = source->labels();
      if (windows.size > 0) {
        requireKindOfDepth(*source);
        result.frames = unreadFrames(*source);
        result.source = std::move(source);
      } else {
        readWhole(*source, windows.last_m, job, result);
      }
      if (result.frames.empty()) throw Error(path, "no frames");
    }
  }
  return result;
}

void checkOrder(const std::vector<std::string>& operands, const InputFlags& input) {
  const std::string& last = operands.back();
  const auto map = std::find_if(operands.begin(), operands.end() - 1, isMapFile);
  if (map == operands.end() - 1) return;
  const InputKind kind = recogniseInput(last, input.parsed());
  if (kind == InputKind::map || kind == InputKind::graph) return;
  throw UsageError(fmt::format(
      "{} is a map and {} a recording: the operands are QUERY... MAP, the map comes last", *map,
      last));
}

void WindowFlags::declare(Flags& flags) {
  flags.add("--window", size, "frames per query; 0 = the whole QUERY");
  flags.add("--stride", stride, "frames between the starts of two windows; 0 = as --window");
  flags.add("--sequence", sequence,
            "let the windows of a QUERY speak together: a place that gathers evidence over several "
            "of them is accepted");
  flags.add("--track", track,
            "after an accepted window search the next one only where odometry expects it");
  last_m = 150;  // of 1 % drift little more than a metre, and more than any place needs
  flags.add("--last", last_m,
            "a QUERY of one piece that is longer is found by its last metres, because odometry "
            "drifts; 0 = by all of it");
}

void WindowFlags::check() const {
  if (size < 0) throw UsageError(fmt::format("--window = {}, must be >= 0", size));
  if (stride < 0) throw UsageError(fmt::format("--stride = {}, must be >= 0", stride));
  if (!(last_m >= 0)) throw UsageError(fmt::format("--last = {}, must be >= 0", last_m));
  if (stride > 0 && size == 0) throw UsageError("--stride needs --window");
  if (sequence && size == 0) throw UsageError("--sequence needs --window");
  if (track && size == 0) throw UsageError("--track needs --window");
  if (track && sequence) throw UsageError("--track and --sequence exclude one another");
}

std::vector<Window> windowsOf(const QueryInput& input, const WindowFlags& flags) {
  const std::size_t frames = input.size();
  const auto length = static_cast<std::size_t>(flags.size);
  if (length == 0 || length >= frames) return {{0, frames}};
  const std::size_t step = flags.stride > 0 ? static_cast<std::size_t>(flags.stride) : length;
  std::vector<Window> windows;
  for (std::size_t first = 0; first + length <= frames; first += step)
    windows.push_back({first, first + length});
  return windows;
}

const Query& wholeQuery(const QueryInput& input) { return *input.whole; }

void forEachWindow(const QueryInput& input, const WindowFlags& flags, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take) {
  const std::vector<Window> windows = windowsOf(input, flags);
  if (input.whole) return take(*input.whole, windows[0]);
  const Progress progress = job.narrate.progress("frames");
  FrameTally tally;
  Stopwatch watch;
  double digest_ms = 0;
  std::vector<FrameDigest> kept;  // the last of them is the one that was read last
  auto next = windows.begin();
  digestRecording(*input.source, job.options, [&](FrameDigest frame) {
    tally.add(frame);
    if (progress) progress(tally.frames(), input.size());
    kept.push_back(std::move(frame));
    for (; next != windows.end() && next->last == tally.frames(); ++next) {
      const FrameDigest* end = kept.data() + kept.size();
      const Query query =
          makeQuery(end - (next->last - next->first), end, input.labels, job.options);
      digest_ms += watch.lap_ms();
      take(query, *next);
      watch.lap_ms();
    }
    const std::size_t first = next == windows.end() ? input.size() : next->first;
    const std::size_t before = tally.frames() - kept.size();  // frames that are kept no more
    if (first > before)
      kept.erase(kept.begin(),
                 kept.begin() + static_cast<std::ptrdiff_t>(std::min(first - before, kept.size())));
  });
  tally.say(input.source->name(), digest_ms + watch.lap_ms(), job.narrate);
}

}  // namespace xview::tools
