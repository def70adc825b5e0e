// SPDX-License-Identifier: BSD-3-Clause
#include "queries.h"

#include <fmt/core.h>

#include <algorithm>

#include "xview/depth_plausibility.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

/// What answers say of a frame.
FrameDigest withoutPoints(const FrameDigest& frame) {
  FrameDigest bare;
  bare.number = frame.number;
  bare.stamp_s = frame.stamp_s;
  bare.sensor = frame.sensor;
  bare.T_odom_sensor = frame.T_odom_sensor;
  return bare;
}

void readWhole(const FrameSource& source, const Job& job, QueryInput& result) {
  const Progress progress = job.narrate.progress("frames");
  FrameTally tally;
  Stopwatch watch;
  result.whole =
      std::make_unique<Query>(makeQuery(source, job.options, [&](const FrameDigest& frame) {
        tally.add(frame);
        result.frames.push_back(withoutPoints(frame));
        if (progress) progress(tally.frames(), source.size());
      }));
  tally.say(source.name(), watch.lap_ms(), job.narrate);
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

}  // namespace

QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels, bool windowed) {
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
      if (windowed) {
        requireKindOfDepth(*source);
        result.frames = unreadFrames(*source);
        result.source = std::move(source);
      } else {
        readWhole(*source, job, result);
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
}

void WindowFlags::check() const {
  if (size < 0) throw UsageError(fmt::format("--window = {}, must be >= 0", size));
  if (stride < 0) throw UsageError(fmt::format("--stride = {}, must be >= 0", stride));
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
