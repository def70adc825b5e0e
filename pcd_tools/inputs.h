// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tool.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// The flags that say how to read an INPUT; every command that has inputs declares them.
class InputFlags {
 public:
  void declare(Flags& flags);
  InputOptions parsed() const;  ///< throws UsageError
  const std::string& labels() const { return labels_; }

 private:
  std::string frames_, kind_, labels_, label_field_, instance_field_;
};

/// All frames of a recording, digested, with a stage line on stderr.
std::vector<FrameDigest> digest(const FrameSource& source, const Job& job);

/// A graph file with its label set: --labels, else classes.yaml beside the file, else `fallback`,
/// else generic names. Edges are made by radius search if the file has none.
struct LabelledGraph {
  LabelSet labels;
  SemanticGraph graph;
};
LabelledGraph readLabelledGraph(const std::string& path, const InputFlags& input,
                                const Options& options, const LabelSet* fallback = nullptr);

/// The MAP operand: a map file, or anything a map can be built of on the fly.
SemanticMap readMap(const std::string& path, const InputFlags& input, const Job& job);

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
