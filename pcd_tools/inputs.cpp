// SPDX-License-Identifier: BSD-3-Clause
#include "inputs.h"

#include <fmt/core.h>

#include <filesystem>
#include <set>

#include "xview/graph/edges.h"
#include "xview/io/graph_files.h"
#include "xview/io/label_files.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"
#include "xview/unnamed_classes.h"

namespace xview::tools {
namespace {

constexpr const char* kOfTheMap = "of the map";

LabelSet labelsOfGraph(const std::string& path, const GraphFile& file,
                       const InputOptions& options) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (const auto named = namedLabels(options.labels, folder, file.labels)) return *named;
  if (options.unnamed) return *options.unnamed;
  std::set<std::uint32_t> ids;
  for (const Vertex& vertex : file.graph.vertices) ids.insert(vertex.label);
  return genericLabelSet({ids.begin(), ids.end()});
}

void sayShapes(const LabelSet& unnamed, const Narrative& narrate) {
  std::string shapes;
  for (const auto& [id, info] : unnamed.classes()) {
    if (info.kind != Kind::none && info.kind != Kind::other_object)
      shapes += fmt::format("{} {} as {}", shapes.empty() ? "" : ",", id, toString(info.kind));
  }
  narrate.note(
      shapes.empty()
          ? "the classes have no names, so each counts as an object, the ground too; --labels "
            "names them"
          : "the classes have no names and were judged by their shapes:" + shapes +
                "; --labels names them");
}

void sayGuessedRoles(const LabelSet& labels, const Narrative& narrate) {
  if (labels.isGeneric()) return sayShapes(labels, narrate);
  std::string guessed;
  for (const auto& [id, info] : labels.classes()) {
    if (info.guessed)
      guessed +=
          fmt::format("{} {} = {}", guessed.empty() ? "" : ",", info.name, toString(info.role));
  }
  if (!guessed.empty())
    narrate.note(fmt::format("{} gives no roles; guessed:{}", labels.name(), guessed));
}

SemanticMap mapOfAnything(const std::string& path, const InputFlags& input, const Job& job) {
  InputOptions whole = input.parsed();
  whole.frames = {};  // --frames speaks of the query
  switch (recogniseInput(path, whole)) {
    case InputKind::map:
      return loadMap(path);
    case InputKind::graph: {
      const LabelledGraph file = readLabelledGraph(path, whole, job.options);
      return buildMap(file.graph, file.labels, path, job.options);
    }
    default: {
      const std::unique_ptr<FrameSource> source = openMapInput(path, whole, job);
      return buildMap({source.get()}, job.options, job.narrate.progress("map"));
    }
  }
}

}  // namespace

void InputFlags::declare(Flags& flags) {
  flags.add("--frames", frames_, "only frames A:B[:STEP] of a recording, half-open, by position");
  flags.add("--input-kind", kind_,
            "what the input is, if its path fits two kinds: sequence, semantic_kitti, cloud, "
            "cloud_folder, graph, map, synthia, airsim, tum_rgbd, virtual_kitti, carla");
  flags.add("--labels", labels_, "label set: a shipped one by name, or a classes.yaml");
  flags.add("--label-field", label_field_, "field of a cloud that holds the class");
  flags.add("--instance-field", instance_field_, "field of a cloud that holds the instance");
}

InputOptions InputFlags::parsed() const {
  InputOptions options;
  options.kind = kind_;
  options.labels = labels_;
  options.label_field = label_field_;
  options.instance_field = instance_field_;
  if (!frames_.empty()) options.frames = parseFrameRange(frames_);
  return options;
}

std::unique_ptr<FrameSource> openInput(const std::string& path, const InputOptions& options,
                                       const Job& job) {
  std::unique_ptr<FrameSource> source = openRecording(path, options);
  if (source->labels().name() == kOfTheMap || (options.unnamed && source->labels().isGeneric())) {
    job.narrate.note(path + " names no classes; its ids are taken as those of the map");
  } else {
    sayGuessedRoles(source->labels(), job.narrate);
  }
  return source;
}

std::unique_ptr<FrameSource> openMapInput(const std::string& path, const InputOptions& options,
                                          const Job& job) {
  if (options.unnamed) return openInput(path, options, job);
  std::unique_ptr<FrameSource> source = withRolesByShape(openRecording(path, options), job.options);
  sayGuessedRoles(source->labels(), job.narrate);
  return source;
}

void FrameTally::add(const FrameDigest& frame) {
  ++frames_;
  points_ += frame.cloud.size();
  blobs_ += frame.blobs.size();
  left_out_.no_depth += frame.counts.no_depth;
  left_out_.out_of_range += frame.counts.out_of_range;
  left_out_.ignored_class += frame.counts.ignored_class;
  for (std::size_t i = 0; i < frame.timing_ms.size(); ++i) {
    if (i >= sums_ms_.size()) sums_ms_.emplace_back(frame.timing_ms[i].first, 0);
    sums_ms_[i].second += frame.timing_ms[i].second;
  }
}

void FrameTally::say(const std::string& name, double ms, const Narrative& narrate) const {
  narrate.stage("frames", ms,
                fmt::format("{}: {} frames, {} points, {} blobs", name, frames_, points_, blobs_));
  narrate.detail(
      fmt::format("left out: {} measurements without depth, {} out of range, {} of ignored classes",
                  left_out_.no_depth, left_out_.out_of_range, left_out_.ignored_class));
  std::string means;
  for (const auto& [stage, sum_ms] : sums_ms_)
    means += fmt::format("{} {} {:.2f}", means.empty() ? "" : ",", stage,
                         sum_ms / static_cast<double>(frames_));
  narrate.detail("mean per frame [ms]:" + means);
}

std::vector<FrameDigest> digest(const FrameSource& source, const Job& job) {
  Stopwatch watch;
  std::vector<FrameDigest> frames =
      digestRecording(source, job.options, job.narrate.progress("frames"));
  FrameTally tally;
  for (const FrameDigest& frame : frames) tally.add(frame);
  tally.say(source.name(), watch.lap_ms(), job.narrate);
  return frames;
}

InputOptions inputIn(const InputFlags& input, const LabelSet& map_labels) {
  InputOptions options = input.parsed();
  options.unnamed = LabelSet(map_labels.isGeneric() ? map_labels.name() : kOfTheMap);
  for (const auto& [id, info] : map_labels.classes()) options.unnamed->add(info);
  return options;
}

LabelledGraph readLabelledGraph(const std::string& path, const InputOptions& input,
                                const Options& options) {
  GraphFile file = readGraph(path);
  if (!file.has_edges) connectByRadius(file.graph, options.edges);
  return {labelsOfGraph(path, file, input), std::move(file.graph)};
}

SemanticMap readMap(const std::string& path, const InputFlags& input, const Job& job) {
  Stopwatch watch;
  SemanticMap map = mapOfAnything(path, input, job);
  job.narrate.stage(
      "map", watch.lap_ms(),
      fmt::format("{}: {} vertices, {} edges, {} key frames, {} points", path, map.graph.size(),
                  map.graph.edgeCount(), map.keyframes.size(), map.cloud.size()));
  return map;
}

}  // namespace xview::tools
