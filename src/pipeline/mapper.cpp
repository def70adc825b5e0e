// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <algorithm>

#include "pipeline/gravity.h"
#include "xview/graph/edges.h"
#include "xview/graph/plan_view.h"
#include "xview/options_file.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview {
namespace {

/// A cloud that grows by frames and is thinned whenever it has doubled, so that memory follows the map, not the recording.
class GrowingCloud {
 public:
  explicit GrowingCloud(double voxel_m) : voxel_m_(voxel_m) {}

  void add(const LabelledCloud& cloud) {
    if (cloud.empty()) return;
    if (cloud_.empty()) cloud_.origin = cloud.origin;
    const Eigen::Vector3f shift = (cloud.origin - cloud_.origin).cast<float>();
    for (pcl::PointXYZL point : cloud.points) {
      point.getVector3fMap() += shift;
      cloud_.points.push_back(point);
    }
    if (cloud_.size() > 2 * thinned_size_ + kSlack) thin();
  }
  LabelledCloud finish() {
    thin();
    return std::move(cloud_);
  }

 private:
  static constexpr std::size_t kSlack = 500000;
  void thin() {
    cloud_ = thinByVoxel(cloud_, voxel_m_);
    thinned_size_ = cloud_.size();
  }
  double voxel_m_;
  std::size_t thinned_size_ = 0;
  LabelledCloud cloud_;
};

/// The parts of a map under construction.
class MapUnderConstruction {
 public:
  MapUnderConstruction(const LabelSet& labels, const Options& options)
      : labels_(labels), options_(options), places_(labels, options.merge), plan_(labels, options.plan),
        cloud_(options.map.cloud_voxel_m) {
    map_.labels = labels;
  }

  /// Before the first frame: how the frame of the map has to be turned for z to point up.
  void setUpright(const Eigen::Quaterniond& upright) { upright_ = upright; }

  void add(const FrameDigest& frame, std::uint32_t source) {
    places_.add(frame.blobs, frame.number);
    places_.addSurfacePoints(frame.cloud, frame.number);
    plan_.add(frame.cloud, frame.votes, frame.thin_trusted, Eigen::Isometry3d(upright_), frame.aerial);
    cloud_.add(frame.cloud);
    const Eigen::Vector3d here = frame.T_odom_sensor.translation();
    const bool first = map_.keyframes.empty() || map_.keyframes.back().source != source;
    if (first || (here - map_.keyframes.back().T_map_sensor.translation()).norm() >= options_.map.keyframe_every_m) {
      map_.keyframes.push_back({frame.number, frame.stamp_s, frame.T_odom_sensor, source});
    }
  }
  void addSource(const std::string& name) { map_.sources.push_back(name); }

  SemanticMap finish() {
    map_.graph = places_.graph();
    connectByRadius(map_.graph, options_.edges);
    map_.plan = plan_.build();
    map_.plan.upright = upright_;
    map_.cloud = cloud_.finish();
    map_.options_yaml = toYaml(options_);
    return std::move(map_);
  }

 private:
  LabelSet labels_;
  Options options_;
  PlaceGraphBuilder places_;
  PlanViewBuilder plan_;
  GrowingCloud cloud_;
  Eigen::Quaterniond upright_ = Eigen::Quaterniond::Identity();
  SemanticMap map_;
};

void requireSameLabels(const LabelSet& a, const std::string& name_a, const LabelSet& b, const std::string& name_b) {
  if (a != b) throw Error(name_b, "its classes (label set '" + b.name() + "') are not those of " + name_a + " ('" + a.name() + "')");
}

}  // namespace

SemanticGraph assembleGraph(const std::vector<FrameDigest>& frames, const LabelSet& labels, const Options& options) {
  PlaceGraphBuilder places(labels, options.merge);
  for (const FrameDigest& frame : frames) {
    places.add(frame.blobs, frame.number);
    places.addSurfacePoints(frame.cloud, frame.number);
  }
  SemanticGraph graph = places.graph();
  connectByRadius(graph, options.edges);
  return graph;
}

SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& options, const Progress& progress) {
  std::size_t total = 0, done = 0;
  for (const FrameSource* source : sources) {
    total += source->size();
    requireSameLabels(sources[0]->labels(), sources[0]->name(), source->labels(), source->name());
  }
  MapUnderConstruction map(sources[0]->labels(), options);
  constexpr std::size_t kBatch = 16;  // frames read ahead
  for (std::uint32_t s = 0; s < sources.size(); ++s) {
    map.addSource(sources[s]->name());
    for (std::size_t first = 0; first < sources[s]->size(); first += kBatch) {
      std::vector<FrameDigest> batch(std::min(kBatch, sources[s]->size() - first));
      parallelFor(batch.size(), options.threads, [&](std::size_t i) {
        batch[i] = digestFrame(sources[s]->read(first + i), sources[s]->labels(), options);
      });
      if (done == 0) map.setUpright(uprightRotation(batch.data(), batch.data() + batch.size(), sources[s]->labels()));
      for (const FrameDigest& frame : batch) map.add(frame, s);
      done += batch.size();
      if (progress) progress(done, total);
    }
  }
  return map.finish();
}

SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels, const std::string& source, const Options& options) {
  SemanticMap map;
  map.labels = labels;
  map.graph = graph;
  if (graph.edgeCount() == 0) connectByRadius(map.graph, options.edges);
  map.sources = {source};
  map.options_yaml = toYaml(options);
  return map;
}

}  // namespace xview
