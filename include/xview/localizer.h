// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xview/base/budget.h"
#include "xview/base/localization.h"
#include "xview/base/semantic_place.h"
#include "xview/cloud_recording.h"
#include "xview/map/semantic_map.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {

namespace verdict {
struct Evidence;
struct Verdict;
}  // namespace verdict

struct PlaceIndex;

/// Evidence of a piece of the query about the best hypothesis.
enum class Support {
  kept,           ///< speaks for it
  contradicting,  ///< speaks against it
  unknown         ///< the map was never seen there
};

/// A sample of the query's BEV grid, or a vertex of its graph.
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
/// another sensor. Of a building its height says on which floor.
struct ExpectedPose {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  double radius_m = 0;  ///< greatest horizontal distance of the last sensor from that pose
  double yaw_rad = 0;   ///< greatest difference of heading
};

/// What speaks for one pose of a query.
struct PoseCheck {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  PlaceEvidence evidence;
};

/// Finds queries in one map, which it keeps. Building it makes the search index once; everything
/// else is const and may be called from several threads. All of it throws UsageError where a query
/// has no pose or holds what is no number, where a pose is no rigid motion or lies 1e8 m or more
/// away, and after the localizer was moved from.
///
///     const xview::Localizer localizer(xview::map::openMap("town.xvm"));
///     const xview::Localization fix = localizer.localize(cloud);  // pcl::PointCloud<PointT>
///     if (fix.accepted()) use(fix.T_map_query);                   // p_map = T_map_query * p_query
class Localizer {
 public:
  /// @param map      is moved in, not copied. It decides about the size of all that is looked for
  ///                 in it (semantic_place.h), whatever options.size says.
  /// @param options  of the search and of the queries that the localizer makes
  /// @param names    which classes of two label sets are the same (LabelMatch)
  /// Throws UsageError if an option has no valid value, if the prior of the options lies outside of
  /// the map, or if there is no map; Error if a file that the options name cannot be read.
  explicit Localizer(map::SemanticMap map, const Options& options = {},
                     const ClassNames& names = ClassNames::shipped());
  /// The same for a map that others read as well; it is copied only if its size is not the
  /// canonical one. See map::borrowed for a map that somebody else keeps.
  explicit Localizer(std::shared_ptr<const map::SemanticMap> map, const Options& options = {},
                     const ClassNames& names = ClassNames::shipped());
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;
  ~Localizer();

  double size() const { return size_; }                    ///< of the map; see kTownScale
  const LabelSet& labels() const { return map().labels; }  ///< the classes of the map
  const Options& options() const { return options_; }      ///< as given, with the size of the map

  /// Where is the query in the map? Its classes are those of the map that mean the same
  /// (LabelMatch). What only one of them tells apart is left aside in both: a query that knows
  /// shapes only meets the shapes of the map, kinds of ground that one set lacks are one ground.
  /// With options.scale the answer has a scale: its pose and its hypotheses are those of the query
  /// with all lengths multiplied by it. A query that is not found, or that a Budget cuts, is an
  /// answer with a reason. Throws Error if the query was made with lengths of another size.
  Localization localize(const Query& query) const;
  /// The same, where it is expected only; the prior of the options must hold as well. Throws
  /// UsageError if radius or angle is negative or no number.
  Localization localize(const Query& query, const ExpectedPose& expected) const;
  /// Where is a whole recording? The answer is the pose of its last frame. Throws as query().
  Localization localize(const FrameSource& recording) const;
  /// Where is a cloud of PCL, whose origin is the sensor, or anywhere [m]? `labels`: what the field
  /// `label` of its points means (labels() if they have the classes of the map); without it classes
  /// come from shapes, for which z is to be up, whatever labels the points have. Throws UsageError
  /// if there is a label set and the points have no field `label`.
  template <class PointT>
  Localization localize(const pcl::PointCloud<PointT>& cloud, const LabelSet& labels = {}) const {
    return withinBudget([&] {
      CloudRecording recording(labels);
      recording.add(cloud);
      return localize(recording);
    });
  }

  /// A query from a whole recording, in lengths of the map. A recording without labels, and any
  /// recording in a map that knows shapes only, gets classes from the shapes of its points. Throws
  /// Error if a frame cannot be read.
  Query query(const FrameSource& recording) const;
  /// A query from frames that preprocess() made, in order: a window of a drive as it comes.
  Query query(const std::vector<PreprocessedFrame>& frames, const LabelSet& labels = {}) const;
  /// What a query needs of one frame, and the map's lengths. `labels`: its classes; without them it
  /// gets those of shapes. Throws Error as query().
  PreprocessedFrame preprocess(const Frame& frame, const LabelSet& labels = {}) const;

  /// Whether any pose of a query can be scored, as check() and Sequence ask: not with method walks.
  bool scoresPoses() const;
  /// For each given pose the best one around it, at most `reach_m` away at the last sensor, and
  /// what speaks for it; the given one itself if the best one is farther. UsageError with method
  /// walks, which cannot say, and if the reach is no number.
  std::vector<PoseCheck> check(const Query& query,
                               const std::vector<Eigen::Isometry3d>& T_map_query,
                               double reach_m) const;
  /// Pose, covariance and correspondences for a place that was found otherwise; status, confidence
  /// and reason are left to the caller.
  Localization describe(const Query& query, const PoseCheck& place) const;
  /// The verdict on poses that were found otherwise: that of localize() if it finds the same pose,
  /// else that on the best pose around, beside the places that the search finds; one that is more
  /// than two canonical metres off is not accepted. UsageError with method walks, which cannot say,
  /// and if a pose is no rigid motion or lies 1e8 m or more away.
  std::vector<Localization> judge(const Query& query,
                                  const std::vector<Eigen::Isometry3d>& T_map_query) const;
  /// What the evidence for a place says in this map, with the options of the localizer.
  verdict::Verdict judge(const verdict::Evidence& evidence) const;
  /// False if the prior of the options excludes this pose of the query.
  bool priorAllows(const Query& query, const Eigen::Isometry3d& T_map_query) const;
  /// What each sample and vertex of the query says about the pose of an answer to it; nothing if
  /// the answer has no hypothesis. Throws UsageError if it is none to this query.
  Explanation explain(const Query& query, const Localization& answer) const;

 private:
  struct CoarseIndices;
  struct CanonicalMap;
  Localizer(CanonicalMap map, const Options& options, const ClassNames& names);
  const map::SemanticMap& map() const;  ///< UsageError if it was moved from
  const PlaceIndex& indexFor(const Query& query) const;
  Localization localizeNear(const Query& query, const std::optional<ExpectedPose>& expected,
                            const Eigen::Isometry3d* claimed = nullptr,
                            double second_best_score = 0) const;
  void askFeatures(const Query& query, const PlaceIndex& index, Localization& answer) const;
  void requireSupport(const Query& query, Localization& answer) const;

  double size_;
  Options options_;  ///< in metres
  ClassNames names_;
  std::shared_ptr<const map::SemanticMap> map_;  ///< at canonical scale, as in the index
  std::unique_ptr<const PlaceIndex> index_;
  std::unique_ptr<CoarseIndices> coarse_;  ///< made when the first query comes that needs them
};

}  // namespace xview
