// SPDX-License-Identifier: BSD-3-Clause
#include "inputs.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "xview/graph/edges.h"
#include "xview/io/graph_files.h"
#include "xview/io/label_files.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

LabelSet labelsOfGraph(const std::string& path, const SemanticGraph& graph,
                       const std::string& chosen, const LabelSet* fallback) {
  const std::vector<std::string> shipped = shippedLabelSets();
  if (std::find(shipped.begin(), shipped.end(), chosen) != shipped.end())
    return shippedLabelSet(chosen);
  if (!chosen.empty()) return readLabelSet(chosen);
  const auto beside = std::filesystem::path(path).parent_path() / "classes.yaml";
  if (std::filesystem::exists(beside)) return readLabelSet(beside.string());
  if (fallback) return *fallback;
  std::set<std::uint32_t> ids;
  for (const Vertex& vertex : graph.vertices) ids.insert(vertex.label);
  return genericLabelSet({ids.begin(), ids.end()});
}

/// A saved session as a query: everything the map knows, answered for its last key frame.
std::unique_ptr<Query> queryOfMap(const std::string& path) {
  SemanticMap map = loadMap(path);
  auto query = std::make_unique<Query>();
  query->labels = std::move(map.labels);
  query->graph = std::move(map.graph);
  query->plan = std::move(map.plan);
  query->cloud = std::move(map.cloud);
  for (const Keyframe& keyframe : map.keyframes) query->poses.push_back(keyframe.T_map_sensor);
  if (query->poses.empty()) query->poses.push_back(Eigen::Isometry3d::Identity());
  return query;
}

SemanticMap mapOfAnything(const std::string& path, const InputFlags& input, const Job& job) {
  InputOptions whole = input.parsed();
  whole.frames = {};  // --frames speaks of the query
  switch (recogniseInput(path, whole)) {
    case InputKind::map:
      return loadMap(path);
    case InputKind::graph: {
      const LabelledGraph file = readLabelledGraph(path, input, job.options);
      return buildMap(file.graph, file.labels, path, job.options);
    }
    default: {
      const std::unique_ptr<FrameSource> source = openRecording(path, whole);
      return buildMap({source.get()}, job.options, job.narrate.progress("map"));
    }
  }
}

}  // namespace

void InputFlags::declare(Flags& flags) {
  flags.add("--frames", frames_, "only frames A:B[:STEP] of a recording, half-open, by position");
  flags.add("--input-kind", kind_,
            "what the input is, if its path fits two kinds: sequence, semantic_kitti, cloud, "
            "cloud_folder, graph, map");
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

std::vector<FrameDigest> digest(const FrameSource& source, const Job& job) {
  Stopwatch watch;
  std::vector<FrameDigest> frames =
      digestRecording(source, job.options, job.narrate.progress("frames"));
  std::size_t points = 0, blobs = 0;
  for (const FrameDigest& frame : frames) {
    points += frame.cloud.size();
    blobs += frame.blobs.size();
  }
  job.narrate.stage("frames", watch.lap_ms(),
                    fmt::format("{}: {} frames, {} points, {} blobs", source.name(), frames.size(),
                                points, blobs));
  return frames;
}

LabelledGraph readLabelledGraph(const std::string& path, const InputFlags& input,
                                const Options& options, const LabelSet* fallback) {
  GraphFile file = readGraph(path);
  if (!file.has_edges) connectByRadius(file.graph, options.edges);
  return {labelsOfGraph(path, file.graph, input.labels(), fallback), std::move(file.graph)};
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

QueryInput readQuery(const std::string& path, const InputFlags& input, const Job& job,
                     const LabelSet& map_labels) {
  QueryInput result;
  result.path = path;
  const InputOptions options = input.parsed();
  switch (recogniseInput(path, options)) {
    case InputKind::map:
      result.whole = queryOfMap(path);
      result.labels = result.whole->labels;
      break;
    case InputKind::graph: {
      LabelledGraph file = readLabelledGraph(path, input, job.options, &map_labels);
      result.labels = std::move(file.labels);
      result.whole = std::make_unique<Query>(makeQuery(file.graph, result.labels, job.options));
      break;
    }
    default: {
      const std::unique_ptr<FrameSource> source = openRecording(path, options);
      result.labels = source->labels();
      result.frames = digest(*source, job);
      if (result.frames.empty()) throw Error(path, "no frames");
    }
  }
  return result;
}

void checkWindow(int size, int stride) {
  if (size < 0) throw UsageError(fmt::format("--window = {}, must be >= 0", size));
  if (stride < 0) throw UsageError(fmt::format("--stride = {}, must be >= 0", stride));
  if (stride > 0 && size == 0) throw UsageError("--stride needs --window");
}

std::vector<Window> windowsOf(const QueryInput& input, int size, int stride) {
  const std::size_t frames = input.size();
  const auto length = static_cast<std::size_t>(size);
  if (length == 0 || length >= frames) return {{0, frames}};
  const std::size_t step = stride > 0 ? static_cast<std::size_t>(stride) : length;
  std::vector<Window> windows;
  for (std::size_t first = 0; first + length <= frames; first += step)
    windows.push_back({first, first + length});
  return windows;
}

Query queryOf(const QueryInput& input, const Window& window, const Options& options) {
  if (input.whole) return *input.whole;
  return makeQuery(input.frames.data() + window.first, input.frames.data() + window.last,
                   input.labels, options);
}

}  // namespace xview::tools
