// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <deque>
#include <utility>

#include "pipeline/best_looks.h"
#include "pipeline/gravity.h"
#include "pipeline/growing_place.h"
#include "pipeline/place_graph.h"
#include "pipeline/point_sigma.h"
#include "xview/graph/edges.h"
#include "xview/graph/plan_view.h"
#include "xview/localizer.h"
#include "xview/types/median.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

/// Adds the times of the frames, stage by stage.
void addTimings(const FrameDigest* first, const FrameDigest* last, Timings& sum) {
  for (const FrameDigest* frame = first; frame != last; ++frame) {
    for (const auto& [stage, ms] : frame->timing_ms) {
      auto it = sum.begin();
      while (it != sum.end() && it->first != stage) ++it;
      if (it == sum.end())
        sum.emplace_back(stage, ms);
      else
        it->second += ms;
    }
  }
}

/// Those that are known as well as their place allows.
void keepBestLooks(Query& query) {
  const std::vector<bool> keep = bestLooks(query.cloud);
  std::vector<float> sigmas;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    if (!keep[i]) continue;
    query.cloud.points[kept] = query.cloud.points[i];
    query.cloud_seen_from[kept++] = query.cloud_seen_from[i];
    sigmas.push_back(query.cloud.points[i].sigma);
  }
  query.cloud.points.resize(kept);
  query.cloud_seen_from.resize(kept);
  query.cloud_sigma_m = medianOf(std::move(sigmas));
}

/// The points of the last metres of travel that are known well enough.
void addRecentPoints(const FrameDigest* first, const FrameDigest* last,
                     const RefineOptions& options, Query& query) {
  if (first == last) return;
  query.cloud.origin = (last - 1)->cloud.origin;
  double travelled = 0;
  for (const FrameDigest* frame = last; frame-- != first;) {
    const std::size_t added = appendKnownPoints(*frame, options.max_sigma_m, query.cloud);
    query.cloud_seen_from.insert(query.cloud_seen_from.end(), added,
                                 static_cast<std::uint32_t>(frame - first));
    if (frame == first) break;
    travelled +=
        (frame->T_odom_sensor.translation() - (frame - 1)->T_odom_sensor.translation()).norm();
    if (travelled > options.reach_m) break;
  }
  if (!query.cloud.empty()) keepBestLooks(query);
}

/// A query of frames that come one by one. Only those of the last metres of travel are kept, for
/// their points.
class GrowingQuery {
 public:
  GrowingQuery(const LabelSet& labels, const Options& options)
      : reach_m_(options.refine.reach_m), options_(options), place_(labels, options) {
    query_.labels = labels;
  }

  void add(FrameDigest frame) {
    addTimings(&frame, &frame + 1, query_.timing_ms);
    Stopwatch watch;
    if (!query_.poses.empty())
      travelled_m_ +=
          (frame.T_odom_sensor.translation() - query_.poses.back().translation()).norm();
    query_.poses.push_back(frame.T_odom_sensor);
    query_.frames.push_back(frame.number);
    query_.sensor = frame.sensor;
    recent_.push_back({frame, travelled_m_});
    while (travelled_m_ - recent_.front().travelled_m > reach_m_) recent_.pop_front();
    place_.add(std::move(frame));
    graph_ms_ += watch.lap_ms();
  }

  Query finish() {
    Stopwatch watch;
    place_.endRecording();
    GrowingPlace::Place place = place_.finish();
    query_.plan = std::move(place.plan);
    query_.gravity = std::move(place.gravity);
    query_.graph = std::move(place.graph);
    addRecent();
    query_.timing_ms.emplace_back("graph", graph_ms_ + watch.lap_ms());
    return std::move(query_);
  }

 private:
  void addRecent() {
    const auto before = static_cast<std::uint32_t>(query_.poses.size() - recent_.size());
    std::vector<FrameDigest> frames;
    for (Recent& recent : recent_) frames.push_back(std::move(recent.frame));
    addRecentPoints(frames.data(), frames.data() + frames.size(), options_.refine, query_);
    for (std::uint32_t& frame : query_.cloud_seen_from) frame += before;
  }

  struct Recent {
    FrameDigest frame;
    double travelled_m;  ///< until this frame
  };
  double reach_m_;
  Options options_;
  GrowingPlace place_;
  Query query_;
  std::deque<Recent> recent_;
  double travelled_m_ = 0, graph_ms_ = 0;
};

}  // namespace

Query makeQuery(const FrameDigest* first, const FrameDigest* last, const LabelSet& labels,
                const Options& options) {
  Query query;
  query.labels = labels;
  addTimings(first, last, query.timing_ms);
  Stopwatch watch;
  PlaceGraph places(labels, options);
  PlanViewBuilder plan(labels, options.plan);
  query.gravity = gravityOf(first, last, labels, options.gravity);
  const Eigen::Quaterniond upright = query.gravity.upright;
  for (const FrameDigest* frame = first; frame != last; ++frame) {
    places.add(*frame);
    if (query.gravity.known)
      plan.add(frame->cloud, frame->votes, frame->thin_trusted, Eigen::Isometry3d(upright),
               frame->aerial);
    query.poses.push_back(frame->T_odom_sensor);
    query.frames.push_back(frame->number);
    query.sensor = frame->sensor;
  }
  if (query.poses.empty())
    query.poses.push_back(Eigen::Isometry3d::Identity());  // nothing was seen, from nowhere
  query.plan = plan.build();
  query.plan.upright = upright;
  query.graph = places.finish(query.plan);
  addRecentPoints(first, last, options.refine, query);
  query.timing_ms.emplace_back("graph", watch.lap_ms());
  return query;
}

Query makeQuery(const FrameSource& source, const Options& options,
                const std::function<void(const FrameDigest&)>& seen) {
  GrowingQuery query(source.labels(), options);
  digestRecording(source, options, [&](FrameDigest frame) {
    if (seen) seen(frame);
    query.add(std::move(frame));
  });
  return query.finish();
}

Query makeQuery(const SemanticGraph& graph, const LabelSet& labels, const Options& options) {
  Stopwatch watch;
  Query query;
  query.labels = labels;
  query.graph = graph;
  if (graph.edgeCount() == 0) connectByRadius(query.graph, options.edges);
  query.gravity = gravityOf(graph, labels, options.gravity);
  query.poses.push_back(Eigen::Isometry3d::Identity());
  query.timing_ms.emplace_back("graph", watch.lap_ms());
  return query;
}

Query makeQuery(SemanticMap map, const Options& options) {
  Query query;
  query.gravity = gravityOf(map, options.gravity);
  query.labels = std::move(map.labels);
  query.graph = std::move(map.graph);
  query.plan = std::move(map.plan);
  query.cloud = std::move(map.cloud);
  for (const Keyframe& keyframe : map.keyframes) query.poses.push_back(keyframe.T_map_sensor);
  if (query.poses.empty()) query.poses.push_back(Eigen::Isometry3d::Identity());
  return query;
}

}  // namespace xview
