// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "xview/explanation.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"
#include "xview/options.h"
#include "xview/types/gravity.h"
#include "xview/types/localization.h"
#include "xview/verify/verdict.h"

namespace xview {

/// What is to be found in a map: a place graph in its own odometry frame and, if it came from a
/// recording, what was seen.
struct Query {
  LabelSet labels;
  SemanticGraph graph;
  PlanView plan;        ///< empty for bare graphs
  LabelledCloud cloud;  ///< for refinement; empty for bare graphs
  std::vector<std::uint32_t>
      cloud_seen_from;       ///< per point of the cloud, a position in poses; empty = unknown
  double cloud_sigma_m = 0;  ///< typical depth error of the points
  std::vector<Eigen::Isometry3d>
      poses;  ///< T_odom_sensor of its frames; the last one is answered. Identity for bare graphs
  std::vector<std::int64_t> frames;  ///< their numbers; empty for bare graphs
  Sensor sensor = Sensor::cloud;
  Gravity gravity;    ///< which way is up in its frame; without that it has no plan view
  Timings timing_ms;  ///< read, lift, blobs, graph
};

/// A query from a window of frames.
Query makeQuery(const FrameDigest* first, const FrameDigest* last, const LabelSet& labels,
                const Options& options);
/// A query from a whole recording, frame by frame: memory follows the place, not the number of
/// frames. The same as from its digests, but that the first frames alone tell which way is up.
/// `seen` is called with every frame, in order.
Query makeQuery(const FrameSource& source, const Options& options,
                const std::function<void(const FrameDigest&)>& seen = {});
/// A query from a bare graph.
Query makeQuery(const SemanticGraph& graph, const LabelSet& labels, const Options& options);
/// A query from a saved session: everything the map knows, answered for its last key frame.
Query makeQuery(SemanticMap map, const Options& options);

/// Where a query is expected, from something else than the query: odometry since the last fix,
/// another sensor.
struct ExpectedPose {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  double radius_m = 0;  ///< the last sensor is so near to where that pose puts it (horizontally)
  double yaw_rad = 0;   ///< and turned by at most so much against it
};

/// What speaks for one pose of a query.
struct PoseCheck {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  verify::Evidence evidence;  ///< of this pose; no runner-up
};

/// Finds queries in one map. Building it makes the search index once; localize() is const and may
/// be called from several threads.
class Localizer {
 public:
  /// The map must outlive the localizer.
  Localizer(const SemanticMap& map, const Options& options);
  ~Localizer();

  /// Throws Error if the labels of the query cannot be those of the map. With options.scale the
  /// answer has a scale: its pose and its hypotheses are those of the query with all lengths
  /// multiplied by it.
  Localization localize(const Query& query) const;
  /// The same, where it is expected only; the prior of the options must hold as well.
  Localization localize(const Query& query, const ExpectedPose& expected) const;

  /// For each given pose the best one around it, at most `reach_m` away at the last sensor, and
  /// what speaks for it; the given one itself if the best one is farther. UsageError with method
  /// walks, which cannot say.
  std::vector<PoseCheck> check(const Query& query,
                               const std::vector<Eigen::Isometry3d>& T_map_query,
                               double reach_m) const;
  /// Pose, covariance and correspondences for a place that was found otherwise; status, confidence
  /// and reason are left to the caller.
  Localization describe(const Query& query, const PoseCheck& place) const;
  /// False if the prior of the options excludes this pose of the query.
  bool priorAllows(const Query& query, const Eigen::Isometry3d& T_map_query) const;
  /// What each sample and vertex of the query says about the pose of an answer to it; nothing if
  /// the answer has no hypothesis.
  Explanation explain(const Query& query, const Localization& answer) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace xview
