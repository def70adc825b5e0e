// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "place/lift.h"
#include "tool.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// The flags that say how to read an INPUT; every command that has inputs declares them.
class InputFlags {
 public:
  InputFlags() = default;
  /// Of a caller who has no flags to parse.
  explicit InputFlags(io::InputOptions options) : given_(std::move(options)) {}
  void declare(Flags& flags);
  void declareWithMap(Flags& flags);  ///< for commands with the operand MAP
  io::InputOptions parsed() const;    ///< throws UsageError
  const std::string& mapLabels() const { return map_labels_; }  ///< --map-labels

 private:
  std::optional<io::InputOptions> given_;
  std::string frames_, kind_, labels_, map_labels_, class_names_, label_field_, instance_field_,
      mount_, topic_, odometry_;
};

/// The flags of commands that give a verdict: the risk of an acceptance, and what a query may take:
/// its frames, and what finds it; with windows the latter only, because they share frames.
class VerdictFlags {
 public:
  void declare(Flags& flags);
  bool any() const { return risk_ != 0 || limits_.any(); }  ///< was given
  /// Throws UsageError.
  void applyTo(Job& job) const;

 private:
  BudgetLimits limits_;
  double risk_ = 0;  ///< 0 = that of the options
};

/// Opens a recording; says on stderr what its reader guessed or left out, and which roles of
/// classes were only guessed.
std::unique_ptr<FrameSource> openInput(const std::string& path, const io::InputOptions& options,
                                       const Job& job);

/// The same for what a place is made of: classes without names are judged by their shapes, and all
/// are brought into those of options.map_labels, if they are given.
std::unique_ptr<FrameSource> openPlaceInput(const std::string& path,
                                            const io::InputOptions& options, const Job& job);

/// How to read what shall be found in a map or added to it.
io::InputOptions inputIn(const InputFlags& input, const LabelSet& map_labels);

/// The job with what the map decides about all that is looked for in it: its size. Says so if
/// another one was asked for.
Job inMap(Job job, const map::SemanticMap& map);

/// What the path is (io::recogniseInput). If its bytes told, the options say so from now on, and
/// nobody reads them for that again; a guess is said.
io::InputKind chooseKind(const std::string& path, io::InputOptions& options, const Job& job);

/// A graph file with its label set (labelsOfGraph). Edges are made by radius search if the file has
/// none.
Place readLabelledGraph(const std::string& path, const io::InputOptions& input, const Job& job);

/// What a map or a graph file holds; nothing if the path is a recording (chooseKind).
std::optional<Place> readStored(const std::string& path, io::InputOptions& input, const Job& job);

/// What recordings in one frame become.
enum class RecordingsUse { map, addition };

/// A map of recordings in one frame, or what is added to one (buildVisit). It is said what of them
/// was left out. `seen` is called with every frame, in order.
map::SemanticMap mapOfRecordings(
    const std::vector<const FrameSource*>& sources, const Job& job,
    RecordingsUse use = RecordingsUse::map,
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen = {});

/// A map of anything. A graph or a recording is first brought into the frame of the map, if that is
/// another one.
map::SemanticMap mapOf(const std::string& path, io::InputOptions input, const Job& job,
                       const std::optional<Eigen::Isometry3d>& T_map_input = {});

/// Throws Error with the path if nothing can be found in the map.
void requireNotEmpty(const map::SemanticMap& map, const std::string& path);
/// "12 vertices, 3 key frames, 456 points".
std::string contentsText(const map::SemanticMap& map);

/// The MAP operand: a map file, of which much stays packed (map::openMap), or anything a map can be
/// built of on the fly.
map::SemanticMap readMap(const std::string& path, const InputFlags& input, const Job& job);
/// The same with all of it in memory, to draw or compare it.
map::SemanticMap readWholeMap(const std::string& path, const InputFlags& input, const Job& job);

/// A QUERY operand: what a map, a graph or a recording holds, or a recording yet to be cut.
struct QueryInput {
  std::string path;
  LabelSet labels;
  std::unique_ptr<FrameSource> source;  ///< all frames of a recording
  std::optional<Query> whole;           ///< the query, unless it is to be cut into windows
  io::InputOptions options;             ///< how it was read; map_labels: the classes of the map
  std::size_t used_from = 0;            ///< position of the first frame that took part in `whole`
  std::size_t size() const { return source ? source->size() : 1; }
  std::vector<Eigen::Isometry3d> poses() const;  ///< T_odom_sensor of the frames of a recording
  LabelMatch inMap() const;                      ///< its classes and those of the map
};
/// A recording is opened, but not read. It keeps its own classes, unless the map knows shapes only.
QueryInput openQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels);
/// Everything becomes one query; of a recording its last metres, if last_m > 0. Its points are
/// forgotten on the way. If the Budget ends before, nothing was seen: no Localizer answers more.
QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels, double last_m = 0);

/// Half-open range of positions in a recording.
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};
/// Calls take(query, window) for windows of a recording, which are in order. It is preprocessed
/// once, whatever the windows share, and no more of it is kept than the next window needs. Each
/// window has its own Budget of job.limits.
void forEachWindow(const QueryInput& input, const std::vector<Window>& windows, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take);

/// Throws UsageError if the operands QUERY... MAP look swapped: a map file is asked for, and what
/// it should be found in is a recording.
void checkOrder(const std::vector<std::string>& operands, const InputFlags& input);

/// Calls take(make(frame)) for all frames, in order. Frames are read and made something of on
/// options.threads threads, a few of them in memory at a time; `stage` names the bar.
template <class Make, class Take>
void forEachFrame(const FrameSource& source, const Job& job, const char* stage, Make&& make,
                  Take&& take) {
  constexpr std::size_t kAhead = 16;
  const Progress progress = job.narrate.progress(stage);
  std::vector<decltype(make(source.read(0)))> made(kAhead);
  makeInOrder(
      source.size(), job.options.threads, kAhead,
      [&](std::size_t i) { made[i % kAhead] = make(source.read(i)); },
      [&](std::size_t i) {
        take(std::move(made[i % kAhead]));
        if (progress) progress(i + 1, source.size());
      });
}

/// The measurements of all frames in the odometry frame, one behind the other, thinned to one point
/// per voxel and class (0 = all). Throws Error if nothing is left.
LabelledCloud liftAll(const FrameSource& source, const Job& job, double voxel_m,
                      LiftCounts* counts = nullptr);

}  // namespace xview::tools
