// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "pipeline/gravity.h"
#include "pipeline/place_graph.h"
#include "pipeline/point_sigma.h"
#include "xview/graph/edges.h"
#include "xview/graph/plan_view.h"
#include "xview/localizer.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

/// Adds the times of the frames, stage by stage.
void addTimings(const FrameDigest* first, const FrameDigest* last, Timings& sum) {
  for (const FrameDigest* frame = first; frame != last; ++frame) {
    for (const auto& [stage, ms] : frame->timing_ms) {
      auto it = sum.begin();
      while (it != sum.end() && it->first != stage) ++it;
      if (it == sum.end()) sum.emplace_back(stage, ms);
      else it->second += ms;
    }
  }
}

/// The points of the last metres of travel that are known well enough.
void addRecentPoints(const FrameDigest* first, const FrameDigest* last, const RefineOptions& options, Query& query) {
  if (first == last) return;
  query.cloud.origin = (last - 1)->cloud.origin;
  std::vector<double> sigmas;
  double travelled = 0;
  for (const FrameDigest* frame = last; frame-- != first;) {
    const Eigen::Vector3f shift = (frame->cloud.origin - query.cloud.origin).cast<float>();
    for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
      const double sigma = pointSigma(*frame, i);
      if (sigma > options.max_sigma_m) continue;
      pcl::PointXYZL point = frame->cloud.points[i];
      point.getVector3fMap() += shift;
      query.cloud.points.push_back(point);
      query.cloud_seen_from.push_back(static_cast<std::uint32_t>(frame - first));
      sigmas.push_back(sigma);
    }
    if (frame == first) break;
    travelled += (frame->T_odom_sensor.translation() - (frame - 1)->T_odom_sensor.translation()).norm();
    if (travelled > options.reach_m) break;
  }
  if (sigmas.empty()) return;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  query.cloud_sigma_m = *middle;
}

}  // namespace

Query makeQuery(const FrameDigest* first, const FrameDigest* last, const LabelSet& labels, const Options& options) {
  Query query;
  query.labels = labels;
  addTimings(first, last, query.timing_ms);
  Stopwatch watch;
  PlaceGraph places(labels, options);
  PlanViewBuilder plan(labels, options.plan);
  const Eigen::Quaterniond upright = uprightRotation(first, last, labels);
  for (const FrameDigest* frame = first; frame != last; ++frame) {
    places.add(*frame);
    plan.add(frame->cloud, frame->votes, frame->thin_trusted, Eigen::Isometry3d(upright), frame->aerial);
    query.poses.push_back(frame->T_odom_sensor);
    query.frames.push_back(frame->number);
    query.sensor = frame->sensor;
  }
  if (query.poses.empty()) query.poses.push_back(Eigen::Isometry3d::Identity());  // nothing was seen, from nowhere
  query.plan = plan.build();
  query.plan.upright = upright;
  query.graph = places.finish(query.plan);
  addRecentPoints(first, last, options.refine, query);
  query.timing_ms.emplace_back("graph", watch.lap_ms());
  return query;
}

Query makeQuery(const SemanticGraph& graph, const LabelSet& labels, const Options& options) {
  Stopwatch watch;
  Query query;
  query.labels = labels;
  query.graph = graph;
  if (graph.edgeCount() == 0) connectByRadius(query.graph, options.edges);
  query.poses.push_back(Eigen::Isometry3d::Identity());
  query.timing_ms.emplace_back("graph", watch.lap_ms());
  return query;
}

}  // namespace xview
