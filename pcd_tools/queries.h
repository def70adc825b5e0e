// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "inputs.h"
#include "xview/localizer.h"

namespace xview::tools {

/// A QUERY operand, read and digested once, so that windows can share its frames.
struct QueryInput {
  std::string path;
  LabelSet labels;
  std::vector<FrameDigest> frames;  ///< recordings
  std::unique_ptr<Query> whole;     ///< graphs and maps, which have no frames
  std::size_t size() const { return whole ? 1 : frames.size(); }
};
QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels);

/// Half-open range of positions in QueryInput::frames.
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};
/// Throws UsageError if the flags make no sense.
void checkWindow(int size, int stride);
/// Windows of `size` frames, `stride` apart (0 = as size); size 0 = one window of everything. A
/// recording shorter than a window is one window.
std::vector<Window> windowsOf(const QueryInput& input, int size, int stride);

Query queryOf(const QueryInput& input, const Window& window, const Options& options);

}  // namespace xview::tools
