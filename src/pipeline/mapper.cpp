// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include "xview/graph/edges.h"
#include "xview/options_file.h"
#include "xview/types/error.h"

namespace xview {
namespace {

/// The options that a map remembers. The number of threads changes no result, so it is none of
/// them.
std::string recordOf(Options options) {
  options.threads = Options().threads;
  return toYaml(options);
}

void requireSameLabels(const LabelSet& a, const std::string& name_a, const LabelSet& b,
                       const std::string& name_b) {
  if (a != b)
    throw Error(name_b, "its classes (label set '" + b.name() + "') are not those of " + name_a +
                            " ('" + a.name() + "')");
}

}  // namespace

SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& options,
                     const Progress& progress) {
  std::size_t total = 0, done = 0;
  for (const FrameSource* source : sources) {
    total += source->size();
    requireSameLabels(sources[0]->labels(), sources[0]->name(), source->labels(), source->name());
    requireGraphSpace(options, source->sensor(), source->name());
  }
  if (progress) progress(0, total);
  PlaceBuilder place(sources[0]->labels(), options, PlaceUse::map);
  SemanticMap map;
  for (const FrameSource* source : sources) {
    digestRecording(*source, options, [&](FrameDigest frame) {
      place.add(std::move(frame));
      if (progress) progress(++done, total);
    });
    map.source_of_pose.resize(place.endRecording(), static_cast<std::uint32_t>(map.sources.size()));
    map.sources.push_back(source->name());
  }
  static_cast<Place&>(map) = place.finish();
  map.options_yaml = recordOf(options);
  return map;
}

SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels, const std::string& source,
                     const Options& options) {
  SemanticMap map;
  map.labels = labels;
  map.graph = graph;
  if (graph.edgeCount() == 0) connectByRadius(map.graph, options.edges);
  map.sources = {source};
  map.options_yaml = recordOf(options);
  return map;
}

}  // namespace xview
