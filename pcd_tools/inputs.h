// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tool.h"
#include "xview/io/recording.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"

namespace xview::tools {

/// The flags that say how to read an INPUT; every command that has inputs declares them.
class InputFlags {
 public:
  void declare(Flags& flags);
  InputOptions parsed() const;  ///< throws UsageError

 private:
  std::string frames_, kind_, labels_, label_field_, instance_field_;
};

/// Opens a recording; says on stderr which roles of classes were only guessed, and whose classes it
/// was given if it names none.
std::unique_ptr<FrameSource> openInput(const std::string& path, const InputOptions& options,
                                       const Job& job);

/// The same for what a map is made of: if it names no classes, and none are offered, they are
/// judged by their shapes.
std::unique_ptr<FrameSource> openMapInput(const std::string& path, const InputOptions& options,
                                          const Job& job);

/// What became of the frames of a recording, for people.
class FrameTally {
 public:
  void add(const FrameDigest& frame);
  std::size_t frames() const { return frames_; }
  void say(const std::string& name, double ms, const Narrative& narrate) const;

 private:
  std::size_t frames_ = 0, points_ = 0, blobs_ = 0;
  LiftCounts left_out_;
  Timings sums_ms_;
};

/// All frames of a recording, digested, with a stage line on stderr.
std::vector<FrameDigest> digest(const FrameSource& source, const Job& job);

/// How to read what shall be found in a map or added to it: if it names no classes, they are those
/// of the map.
InputOptions inputIn(const InputFlags& input, const LabelSet& map_labels);

/// A graph file with its label set: --labels, else that of its comments, else classes.yaml beside
/// the file, else input.unnamed, else generic names. Edges are made by radius search if the file
/// has none.
struct LabelledGraph {
  LabelSet labels;
  SemanticGraph graph;
};
LabelledGraph readLabelledGraph(const std::string& path, const InputOptions& input,
                                const Options& options);

/// The MAP operand: a map file, or anything a map can be built of on the fly.
SemanticMap readMap(const std::string& path, const InputFlags& input, const Job& job);

}  // namespace xview::tools
