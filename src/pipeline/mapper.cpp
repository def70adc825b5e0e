// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <algorithm>
#include <optional>

#include "pipeline/depth_plausibility.h"
#include "pipeline/gravity.h"
#include "pipeline/place_graph.h"
#include "pipeline/point_sigma.h"
#include "xview/graph/edges.h"
#include "xview/graph/plan_view.h"
#include "xview/localizer.h"
#include "xview/options_file.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview {
namespace {

constexpr std::size_t kFramesAhead = 8;        ///< digested and not yet merged
constexpr std::size_t kFramesForGravity = 16;  ///< that say together which way is up

/// A cloud that grows by frames and is thinned whenever it has doubled, so that memory follows the map, not the recording.
class GrowingCloud {
 public:
  GrowingCloud(double voxel_m, double max_sigma_m) : voxel_m_(voxel_m), max_sigma_m_(max_sigma_m) {}

  void add(const FrameDigest& frame) {
    const LabelledCloud& cloud = frame.cloud;
    if (cloud.empty()) return;
    if (cloud_.empty()) cloud_.origin = cloud.origin;
    const Eigen::Vector3f shift = (cloud.origin - cloud_.origin).cast<float>();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (pointSigma(frame, i) > max_sigma_m_) continue;
      pcl::PointXYZL point = cloud.points[i];
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
  double voxel_m_, max_sigma_m_;
  std::size_t thinned_size_ = 0;
  LabelledCloud cloud_;
};

/// The options that a map remembers. The number of threads changes no result, so it is none of them.
std::string recordOf(Options options) {
  options.threads = Options().threads;
  return toYaml(options);
}

/// The parts of a map under construction.
class MapUnderConstruction {
 public:
  MapUnderConstruction(const LabelSet& labels, const Options& options)
      : labels_(labels), options_(options), places_(labels, options), plan_(labels, options.plan),
        cloud_(options.map.cloud_voxel_m, options.refine.max_sigma_m) {
    map_.labels = labels;
  }

  void beginSource(const std::string& name) { map_.sources.push_back(name); }

  void add(FrameDigest frame) {
    if (upright_) return addUpright(frame);
    waiting_.push_back(std::move(frame));
    if (waiting_.size() == kFramesForGravity) settleUpright();
  }

  void endSource() {
    if (!upright_) settleUpright();
  }

  SemanticMap finish() {
    map_.plan = plan_.build();
    map_.plan.upright = *upright_;
    map_.graph = places_.finish(map_.plan);
    map_.cloud = cloud_.finish();
    map_.options_yaml = recordOf(options_);
    return std::move(map_);
  }

 private:
  /// How the frame of the map has to be turned for z to point up: the first frames tell together.
  void settleUpright() {
    upright_ = uprightRotation(waiting_.data(), waiting_.data() + waiting_.size(), labels_);
    for (const FrameDigest& frame : waiting_) addUpright(frame);
    waiting_.clear();
  }

  void addUpright(const FrameDigest& frame) {
    places_.add(frame);
    plan_.add(frame.cloud, frame.votes, frame.thin_trusted, Eigen::Isometry3d(*upright_), frame.aerial);
    cloud_.add(frame);
    const auto source = static_cast<std::uint32_t>(map_.sources.size() - 1);
    const Eigen::Vector3d here = frame.T_odom_sensor.translation();
    const bool first = map_.keyframes.empty() || map_.keyframes.back().source != source;
    if (first || (here - map_.keyframes.back().T_map_sensor.translation()).norm() >= options_.map.keyframe_every_m) {
      map_.keyframes.push_back({frame.number, frame.stamp_s, frame.T_odom_sensor, source});
    }
  }

  LabelSet labels_;
  Options options_;
  PlaceGraph places_;
  PlanViewBuilder plan_;
  GrowingCloud cloud_;
  std::vector<FrameDigest> waiting_;  ///< until upright_ is known
  std::optional<Eigen::Quaterniond> upright_;
  SemanticMap map_;
};

void requireSameLabels(const LabelSet& a, const std::string& name_a, const LabelSet& b, const std::string& name_b) {
  if (a != b) throw Error(name_b, "its classes (label set '" + b.name() + "') are not those of " + name_a + " ('" + a.name() + "')");
}

}  // namespace

SemanticGraph assembleGraph(const std::vector<FrameDigest>& frames, const LabelSet& labels, const Options& options) {
  return makeQuery(frames.data(), frames.data() + frames.size(), labels, options).graph;
}

SemanticMap buildMap(const std::vector<const FrameSource*>& sources, const Options& options, const Progress& progress) {
  std::size_t total = 0, done = 0;
  for (const FrameSource* source : sources) {
    total += source->size();
    requireSameLabels(sources[0]->labels(), sources[0]->name(), source->labels(), source->name());
    requireGraphSpace(options, source->sensor(), source->name());
  }
  MapUnderConstruction map(sources[0]->labels(), options);
  for (const FrameSource* source : sources) {
    map.beginSource(source->name());
    DepthPlausibility depths;
    std::vector<FrameDigest> ahead(kFramesAhead);
    const auto make = [&](std::size_t i) { ahead[i % kFramesAhead] = digestFrame(source->read(i), source->labels(), options); };
    makeInOrder(source->size(), options.threads, kFramesAhead, make, [&](std::size_t i) {
      FrameDigest frame = std::move(ahead[i % kFramesAhead]);
      depths.add(frame);
      map.add(std::move(frame));
      if (progress) progress(++done, total);
    });
    map.endSource();
    depths.require(*source);
  }
  return map.finish();
}

SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels, const std::string& source, const Options& options) {
  SemanticMap map;
  map.labels = labels;
  map.graph = graph;
  if (graph.edgeCount() == 0) connectByRadius(map.graph, options.edges);
  map.sources = {source};
  map.options_yaml = recordOf(options);
  return map;
}

}  // namespace xview
