// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include "pipeline/best_looks.h"
#include "pipeline/growing_place.h"
#include "pipeline/point_sigma.h"
#include "xview/graph/edges.h"
#include "xview/options_file.h"
#include "xview/types/error.h"

namespace xview {
namespace {

// Distance between the sensor poses that a map remembers [m]: they are drawn, and the last one is
// answered when the map itself is the query.
constexpr double kKeyframeEvery_m = 2;

/// The points that the flags keep.
LabelledCloud keptPoints(const LabelledCloud& cloud, const std::vector<bool>& keep) {
  LabelledCloud kept;
  kept.origin = cloud.origin;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (keep[i]) kept.points.push_back(cloud.points[i]);
  }
  return kept;
}

/// A cloud that grows by frames and is thinned whenever it has doubled, so that memory follows the
/// map, not the recording.
class GrowingCloud {
 public:
  GrowingCloud(double voxel_m, double max_sigma_m) : voxel_m_(voxel_m), max_sigma_m_(max_sigma_m) {}

  void add(const FrameDigest& frame) {
    if (frame.cloud.empty()) return;
    if (cloud_.empty()) cloud_.origin = frame.cloud.origin;
    appendKnownPoints(frame, max_sigma_m_, cloud_);
    if (cloud_.size() > 2 * thinned_size_ + kSlack) thin();
  }
  LabelledCloud finish() {
    thin();
    return keptPoints(cloud_, bestLooks(cloud_));
  }

 private:
  static constexpr std::size_t kSlack = 500000;
  void thin() {
    cloud_ = thinByVoxel(cloud_, voxel_m_);
    thinned_size_ = cloud_.size();
  }
  double voxel_m_, max_sigma_m_;
  std::size_t thinned_size_ = 0;
  LabelledCloud cloud_;
};

/// The options that a map remembers. The number of threads changes no result, so it is none of
/// them.
std::string recordOf(Options options) {
  options.threads = Options().threads;
  return toYaml(options);
}

/// The parts of a map under construction.
class MapUnderConstruction {
 public:
  MapUnderConstruction(const LabelSet& labels, const Options& options)
      : options_(options),
        place_(labels, options),
        cloud_(options.map.cloud_voxel_m, options.refine.max_sigma_m) {
    map_.labels = labels;
  }

  void beginSource(const std::string& name) { map_.sources.push_back(name); }

  void add(FrameDigest frame) {
    cloud_.add(frame);
    addKeyframe(frame);
    place_.add(std::move(frame));
  }

  void endSource() { place_.endRecording(); }

  SemanticMap finish() {
    GrowingPlace::Place place = place_.finish();
    map_.plan = std::move(place.plan);
    map_.graph = std::move(place.graph);
    map_.cloud = cloud_.finish();
    map_.options_yaml = recordOf(options_);
    return std::move(map_);
  }

 private:
  void addKeyframe(const FrameDigest& frame) {
    const auto source = static_cast<std::uint32_t>(map_.sources.size() - 1);
    const Eigen::Vector3d here = frame.T_odom_sensor.translation();
    const bool first = map_.keyframes.empty() || map_.keyframes.back().source != source;
    if (first ||
        (here - map_.keyframes.back().T_map_sensor.translation()).norm() >= kKeyframeEvery_m) {
      map_.keyframes.push_back({frame.number, frame.stamp_s, frame.T_odom_sensor, source});
    }
  }

  Options options_;
  GrowingPlace place_;
  GrowingCloud cloud_;
  SemanticMap map_;
};

void requireSameLabels(const LabelSet& a, const std::string& name_a, const LabelSet& b,
                       const std::string& name_b) {
  if (a != b)
    throw Error(name_b, "its classes (label set '" + b.name() + "') are not those of " + name_a +
                            " ('" + a.name() + "')");
}

}  // namespace

SemanticGraph buildGraph(const FrameSource& source, const Options& options,
                         const std::function<void(const FrameDigest&)>& seen) {
  GrowingPlace place(source.labels(), options);
  digestRecording(source, options, [&](FrameDigest frame) {
    if (seen) seen(frame);
    place.add(std::move(frame));
  });
  place.endRecording();
  return place.finish().graph;
}

SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& options,
                     const Progress& progress) {
  std::size_t total = 0, done = 0;
  for (const FrameSource* source : sources) {
    total += source->size();
    requireSameLabels(sources[0]->labels(), sources[0]->name(), source->labels(), source->name());
    requireGraphSpace(options, source->sensor(), source->name());
  }
  if (progress) progress(0, total);
  MapUnderConstruction map(sources[0]->labels(), options);
  for (const FrameSource* source : sources) {
    map.beginSource(source->name());
    digestRecording(*source, options, [&](FrameDigest frame) {
      map.add(std::move(frame));
      if (progress) progress(++done, total);
    });
    map.endSource();
  }
  return map.finish();
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
