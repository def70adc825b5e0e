// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <limits>
#include <memory>

#include "pipeline/point_quality.h"
#include "xview/alikeness.h"
#include "xview/graph/merge.h"
#include "xview/graph/plan_view.h"
#include "xview/measure_size.h"
#include "xview/options_file.h"
#include "xview/sized_options.h"
#include "xview/types/error.h"
#include "xview/types/label_match.h"

namespace xview {
namespace {

constexpr double kSameUp_rad = 0.03;

/// The options that a map remembers. The number of threads changes no result, so it is none of
/// them.
std::string recordOf(Options options) {
  options.threads = Options().threads;
  return toYaml(options);
}

LabelMatch requireCommonClasses(const LabelSet& addition, const std::string& name,
                                const LabelSet& map) {
  LabelMatch match(addition, map);
  if (!match.isHopeless()) return match;
  throw Error(name, "none of its classes (label set '" + addition.name() +
                        "') is among those of the map ('" + map.name() +
                        "'); name them with a label set");
}

/// The recording in the classes of a map.
std::unique_ptr<const FrameSource> inClassesOf(const LabelSet& labels, const FrameSource& source) {
  return std::make_unique<TranslatedRecording>(
      source, requireCommonClasses(source.labels(), source.name(), labels));
}

/// What messages call it.
std::string nameOf(const map::SemanticMap& addition) {
  return addition.sources.empty() ? "addition" : addition.sources.front();
}

/// Edges found in images and edges of a radius say different things of the same vertices.
void requireSameSpace(const map::SemanticMap& map, const map::SemanticMap& addition) {
  if (map.graph.space == addition.graph.space || map.graph.empty() || addition.graph.empty())
    return;
  throw Error(nameOf(addition), std::string("its graph_space is ") +
                                    toString(addition.graph.space) + ", that of the map is " +
                                    toString(map.graph.space));
}

/// A bare graph has no lengths of its own.
void requireSameSize(const map::SemanticMap& map, const map::SemanticMap& addition) {
  if (map.size == addition.size || addition.plan.known.empty()) return;
  throw Error(nameOf(addition), "it was made with lengths of size " + sizeText(addition.size) +
                                    " and the map with those of size " + sizeText(map.size) +
                                    "; make it again with --size " + sizeText(map.size));
}

void appendCloud(LabelledCloud& cloud, const LabelledCloud& addition, double voxel_m) {
  if (cloud.empty()) {
    cloud = addition;
    return;
  }
  for (Point& point : cloud.points) point.instance = 0;  // numbers of two recordings differ
  appendKnownPoints(addition, std::numeric_limits<double>::infinity(), kNoView, cloud);
  cloud = graph::thinByVoxel(cloud, voxel_m);
}

}  // namespace

map::SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& given,
                          const Progress& progress,
                          const std::function<void(const FrameSource&, const FrameDigest&)>& seen) {
  Options options = given;
  options.size = sizeText(sizeFor(given, sources));
  std::size_t total = 0, done = 0;
  std::vector<std::unique_ptr<const FrameSource>> in_one_set;
  for (const FrameSource* source : sources) {
    total += source->size();
    in_one_set.push_back(inClassesOf(sources[0]->labels(), *source));
    requireGraphSpace(options, source->sensor(), source->name());
  }
  if (progress) progress(0, total);
  PlaceBuilder place(sources[0]->labels(), options, PlaceUse::map);
  map::SemanticMap map;
  for (const auto& source : in_one_set) {
    digestRecording(*source, options, [&](FrameDigest frame) {
      if (seen) seen(*sources[map.sources.size()], frame);
      place.add(std::move(frame));
      if (progress) progress(++done, total);
    });
    map.source_of_pose.resize(place.endRecording(), static_cast<std::uint32_t>(map.sources.size()));
    map.sources.push_back(source->name());
  }
  static_cast<Place&>(map) = place.finish();
  map.options_yaml = recordOf(options);
  map.look_alikes = lookAlikesOf(map, options);
  return map;
}

map::SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels,
                          const std::string& source, const Options& options) {
  map::SemanticMap map;
  map.labels = labels;
  map.graph = graph;
  map.size = sizeFor(options, graph);
  if (graph.edgeCount() == 0) graph::connectByRadius(map.graph, atSize(options, map.size).edges);
  map.sources = {source};
  map.options_yaml = recordOf(options);
  return map;
}

void appendToMap(map::SemanticMap& map, const map::SemanticMap& given, const Options& in_metres) {
  const LabelMatch match = requireCommonClasses(given.labels, nameOf(given), map.labels);
  if (!match.changesNothing()) {
    map::SemanticMap same = given;
    static_cast<Place&>(same) = translated(given, match);
    return appendToMap(map, same, in_metres);
  }
  if (!map.plan.known.empty() && !given.plan.known.empty() &&
      map.plan.upright.angularDistance(given.plan.upright) > kSameUp_rad) {
    throw Error(
        nameOf(given),
        "its frame is tilted against that of the map; only recordings in one frame can be joined");
  }
  requireSameSpace(map, given);
  requireSameSize(map, given);
  const Options options = inTownLengths(in_metres, map.size);
  const Scaled<map::SemanticMap> addition(given, 1 / map.size);
  if (map.size != kTown) scaleLengths(1 / map.size, map);
  graph::mergeGraphs(map.graph, addition->graph, map.labels, options.merge, options.edges);
  graph::mergePlanViews(map.plan, addition->plan);
  appendCloud(map.cloud, addition->cloud, options.map.cloud_voxel_m);
  const auto first_source = static_cast<std::uint32_t>(map.sources.size());
  for (std::size_t i = 0; i < addition->poses.size(); ++i)
    map.addKeyframe(addition->poses[i], addition->frames[i], addition->stamps_s[i],
                    first_source + addition->source_of_pose[i]);
  map.sources.insert(map.sources.end(), addition->sources.begin(), addition->sources.end());
  if (map.size != kTown) scaleLengths(map.size, map);
  map.look_alikes = lookAlikesOf(map, in_metres);
}

}  // namespace xview
