// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "xview/match/plan_field.h"
#include "xview/match/plan_likelihood.h"
#include "xview/types/option_field.h"
#include "xview/types/place.h"
#include "xview/types/plan_view.h"

namespace xview {

struct PlaceOptions {
  double coarse_cell_m = 2;  ///< cell of the exhaustive search; larger is faster and less sure.
                             ///< Taken as the nearest power of two of plan.cell_m
  double max_yaw_step_deg = 6;
  int keep_cells = 4000;        ///< best cells kept by the exhaustive search
  int keep_poses = 100;         ///< distinct poses verified
  int refine_poses = 20;        ///< of these, refined to the end
  double surface_weight = 0.3;  ///< evidence of a surface sample per 2 m
  double object_weight = 2;     ///< evidence of an object
  double map_null_mix = 0.5;  ///< how much the map's own wrong poses count against the learned ones
  int hypotheses = 5;         ///< distinct places reported
  std::string likelihoods;    ///< file of xview learn; empty = what the program comes with
};

template <class Visitor>
void visit(PlaceOptions& o, Visitor&& field) {
  field("coarse_cell_m", o.coarse_cell_m, Range{0.5, 8},
        "cell of the exhaustive (x, y, yaw) search [m]");
  field("max_yaw_step_deg", o.max_yaw_step_deg, Range{0.5, 30},
        "largest yaw step of the search [deg]");
  field("keep_cells", o.keep_cells, Range{100, 1e6}, "best cells kept by the exhaustive search");
  field("keep_poses", o.keep_poses, Range{10, 1e5}, "distinct poses verified on the fine grid");
  field("refine_poses", o.refine_poses, Range{2, 1e4}, "of these, refined to the end");
  field("surface_weight", o.surface_weight, Range{0, 100}, "evidence of a surface sample per 2 m");
  field("object_weight", o.object_weight, Range{0, 100}, "evidence of an object");
  field("map_null_mix", o.map_null_mix, Range{0, 1},
        "weight of the map's own wrong poses against the learned ones in the likelihoods");
  field("hypotheses", o.hypotheses, Range{1, 1000}, "distinct places reported");
  field("likelihoods", o.likelihoods, "file of xview learn; empty = built in");
}

/// On which side of the way of the sensor something lies; none if the sensor did not move.
enum class WaySide : std::uint8_t { none, left, right };

/// A query as the place search sees it: samples about their centre.
struct PlanQuery {
  struct Sample {
    float x = 0, y = 0;  ///< relative to the centre [m]
    std::uint8_t channel = 0;
    WaySide side = WaySide::none;
    float z = 0;  ///< height of the ground there, in the query frame
  };
  struct Ground {
    float x = 0, y = 0, z = 0;  ///< relative to the centre, z in the query frame
  };
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in the query frame
  Viewpoint viewpoint = Viewpoint::ground;
  std::vector<Sample> fine;    ///< one per 3–4 m of surface, and all objects
  std::vector<Sample> coarse;  ///< one per 6–8 m, and all objects
  std::vector<Ground> ground;  ///< heights of ground cells, one per 2 m
  bool empty() const { return fine.empty(); }
};
/// `way`: positions of the sensor in the frame of the view, in order.
PlanQuery makePlanQuery(const PlanView& view, const std::vector<Eigen::Vector2d>& way = {});

/// How far the farthest sample is from the centre [m].
double radiusOf(const std::vector<PlanQuery::Sample>& samples);

/// What a part of the samples says [nats].
struct PlanPart {
  double score = 0;
  double expected = 0;  ///< at a true pose
};

/// A pose that the place search stands for, with what decides whether to believe it.
struct PlanHypothesis {
  PlacePose pose;       ///< query frame to map frame; score in nats
  double z = 0;         ///< height offset: median of map ground minus query ground, measured if
                        ///< both know it at one spot, else from what stands around [m]
  double expected = 0;  ///< score that a true pose would have, over the samples in seen area [nats]
  double known_share = 0;         ///< share of the samples that fall where the map was seen
  PlanPart standing;              ///< upright surfaces and obstacles
  std::array<PlanPart, 2> sides;  ///< left and right of the way
  int objects = 0;                ///< object samples in seen area
  int objects_matched = 0;        ///< of these, with a map object of the channel within 1 m
};

/// What one sample of the query says about a pose.
struct SampleEvidence {
  Channel channel = Channel::road;
  Eigen::Vector2d query = Eigen::Vector2d::Zero();  ///< in the query frame [m]
  Eigen::Vector2d map = Eigen::Vector2d::Zero();    ///< where the pose puts it in the map [m]
  int distance_bin = kUnknownBin;                   ///< of the nearest map sample of the channel
  double nats = 0;                                  ///< contribution to the score of the pose
  double expected = 0;  ///< contribution that a true pose would have on average; 0 in unseen area
};

/// How the ground of the map lies against that of a query under a pose:
/// z_map = z_query + height + slope . (p - p_centre), in map axes about the query centre.
struct GroundFit {
  double height_m = 0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();       ///< [m/m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of height and slope
  int cells = 0;  ///< of ground that agree; 0 = too few to tell
};

/// Search index of one map. Thread-safe after construction.
class PlanPlaces {
 public:
  /// `trajectory`: positions of the sensor when the map was made, in order; used to learn how
  /// similar the map is to itself.
  PlanPlaces(const PlanView& map, const std::vector<Eigen::Vector3d>& trajectory,
             const LikelihoodTable& table, const PlaceOptions& options, int threads);
  ~PlanPlaces();

  bool empty() const;
  /// Distinct places, best first, as many as were refined to the end; empty if nothing can be said.
  std::vector<PlanHypothesis> search(const PlanQuery& query, const PlacePrior& prior_of_centre,
                                     int threads) const;
  /// Climbs from a proposed pose (query frame to map frame) to the best pose around it.
  PlanHypothesis verify(const PlanQuery& query, const PlacePose& proposed) const;
  /// What speaks for one pose (query frame to map frame), without climbing.
  PlanHypothesis describe(const PlanQuery& query, const PlacePose& pose) const;
  /// Score of one pose (query frame to map frame) [nats].
  double score(const PlanQuery& query, const PlacePose& pose) const;
  /// What the score of a pose (query frame to map frame) is the sum of, by sample of
  /// PlanQuery::fine.
  std::vector<SampleEvidence> evidence(const PlanQuery& query, const PlacePose& pose) const;
  /// How the ground lies under a pose (query frame to map frame). `slope_sigma`: how far off level
  /// the query may be [m/m].
  GroundFit fitGround(const PlanQuery& query, const PlacePose& pose, double slope_sigma) const;
  std::size_t bytes() const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace xview
