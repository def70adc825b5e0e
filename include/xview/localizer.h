// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/map/semantic_map.h"
#include "xview/options.h"
#include "xview/place_builder.h"
#include "xview/types/localization.h"
#include "xview/types/semantic_place.h"
#include "xview/verify/verdict.h"

namespace xview {

/// What a piece of the query says about the best hypothesis.
enum class Support {
  kept,           ///< speaks for it
  contradicting,  ///< speaks against it
  unknown         ///< the map was never seen there
};

/// A sample of the query's view from above, or a vertex of its graph.
struct Contribution {
  std::string name;  ///< channel of a sample, class of a vertex
  Support support = Support::unknown;
  Eigen::Vector3d map_position = Eigen::Vector3d::Zero();  ///< where the pose puts it [m]
  std::optional<double> nats;                              ///< its share of the score; samples only
  std::optional<double> expected;  ///< what it would give at a true pose on average; samples only
  /// To the nearest of its kind in the map: in the plane for samples, in space for vertices.
  std::optional<double> residual_m;
};

/// Why a query got its verdict: all samples first, then all vertices.
struct Explanation {
  std::vector<Contribution> contributions;
};

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
  verify::PlaceEvidence evidence;
};

/// Finds queries in one map. Building it makes the search index once; localize() is const and may
/// be called from several threads.
class Localizer {
 public:
  /// The map must outlive the localizer. It decides about the size (semantic_place.h) of all that
  /// is looked for in it. Throws UsageError if the prior of the options lies outside of it.
  Localizer(const map::SemanticMap& map, const Options& options);
  ~Localizer();

  double size() const { return size_; }

  /// The classes of the query are those of the map that mean the same (LabelMatch). What only one
  /// of them tells apart is left aside in both: a query that knows shapes only (withShapeLabels)
  /// meets the shapes of the map, kinds of ground that one set lacks are one ground. Throws Error
  /// if the query was made with lengths of another size. With options.scale the answer has a scale:
  /// its pose and its hypotheses are those of the query with all lengths multiplied by it.
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
  /// What the evidence for a place says in this map, with the options of the localizer.
  verify::Verdict judge(const verify::Evidence& evidence) const;
  /// False if the prior of the options excludes this pose of the query.
  bool priorAllows(const Query& query, const Eigen::Isometry3d& T_map_query) const;
  /// What each sample and vertex of the query says about the pose of an answer to it; nothing if
  /// the answer has no hypothesis.
  Explanation explain(const Query& query, const Localization& answer) const;

 private:
  struct Index;
  struct CoarseIndices;
  const Index& indexFor(const Query& query) const;

  double size_;
  Scaled<map::SemanticMap> map_;  ///< in lengths of a town, as all that the index knows
  std::unique_ptr<const Index> index_;
  std::unique_ptr<CoarseIndices> coarse_;  ///< made when the first query comes that needs them
};

}  // namespace xview
