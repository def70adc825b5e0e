// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "inputs.h"
#include "xview/localizer.h"

namespace xview::tools {

/// A QUERY operand.
struct QueryInput {
  std::string path;
  LabelSet labels;
  std::vector<FrameDigest> frames;      ///< of a recording, without their points
  std::size_t used_from = 0;            ///< position of the first frame that took part in `whole`
  std::unique_ptr<Query> whole;         ///< the query, unless it is cut into windows
  std::unique_ptr<FrameSource> source;  ///< else the recording, which is read window by window
  std::size_t size() const { return frames.empty() ? 1 : frames.size(); }
};
/// Throws UsageError if the operands QUERY... MAP look swapped: a map file is asked for, and what
/// it should be found in is a recording.
void checkOrder(const std::vector<std::string>& operands, const InputFlags& input);

/// Half-open range of positions in QueryInput::frames.
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};
/// The flags that say how a QUERY is cut into windows and how those speak to one another.
struct WindowFlags {
  int size = 0, stride = 0;
  double last_m = 0;      ///< a whole recording is found by so much of its end [m]; 0 = all of it
  bool sequence = false;  ///< with what earlier windows say
  bool track = false;     ///< from fix to fix
  void declare(Flags& flags);
  void check() const;  ///< throws UsageError if they make no sense
};
/// With windows of some size a recording is left to be cut; else it becomes one query, and its
/// points are forgotten on the way.
QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels, const WindowFlags& windows = {});

/// Windows of `size` frames, `stride` apart (0 = as size); size 0 = one window of everything. A
/// recording shorter than a window is one window.
std::vector<Window> windowsOf(const QueryInput& input, const WindowFlags& flags);

/// The query of an input that is not cut.
const Query& wholeQuery(const QueryInput& input);

/// Calls take(query, window) for the windows of an input, in order. A recording is digested once,
/// whatever the windows share, and no more of it is kept than the next window needs.
void forEachWindow(const QueryInput& input, const WindowFlags& flags, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take);

}  // namespace xview::tools
