// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"
#include "xview/types/place.h"

namespace xview {

/// Place search for bare semantic graphs: maps and queries that are vertices with a class and
/// nothing else. Densities and the spacing of surface vertices come from the map, so any set of
/// classes will do.
struct ObjectPlaceOptions {
  double detection = 0.62;         ///< chance that a query finds an object of the map again
  double dynamic_detection = 0.7;  ///< factor on it for things that move between visits
  double surface_detection =
      0.65;              ///< factor on it for vertices of surfaces, which depend on the view
  double sigma_m = 0.9;  ///< of an object's position, map and query together
  double surface_lateral_m = 1.2;  ///< of a surface vertex across the surface
  double roof_offset_m = 5;        ///< of what is seen of a building from above, from its front
  double roof_lateral_m = 1.8;     ///< its error across the front
  double confusion =
      0.05;  ///< chance that a class is taken for a given similar one (pole for sign); 0 = never
  double fine_cell_m = 3;
  double coarse_cell_m = 6;  ///< first look at large maps; a multiple of fine_cell_m
  int keep_cells = 0;        ///< best (x, y, yaw) cells of the first look; 0 = by size of the map
  int keep_poses = 0;        ///< distinct poses verified; 0 = by size of the map
  int refine_poses = 40;     ///< best of them refined to the end
  double negative_weight =
      0.5;  ///< cost of an object of the map that the query should see but does not [nats]
  double negative_radius_m = 8.5;  ///< it should see what is this close to a query vertex
};

template <class Visitor>
void visit(ObjectPlaceOptions& o, Visitor&& field) {
  field("detection", o.detection, Range{0.05, 0.99},
        "chance that a query finds an object of the map again");
  field("dynamic_detection", o.dynamic_detection, Range{0.05, 1},
        "factor on it for classes that move");
  field("surface_detection", o.surface_detection, Range{0.05, 1},
        "factor on it for vertices of surfaces");
  field("sigma_m", o.sigma_m, Range{0.05, 20},
        "position error of objects, map and query together [m]");
  field("surface_lateral_m", o.surface_lateral_m, Range{0.05, 20},
        "error of surface vertices across the surface [m]");
  field("roof_offset_m", o.roof_offset_m, Range{0, 50},
        "of a building seen from above, from its front, on either side [m]");
  field("roof_lateral_m", o.roof_lateral_m, Range{0.05, 50}, "error of that across the front [m]");
  field("confusion", o.confusion, Range{0, 0.5}, "chance that a class is taken for a similar one");
  field("fine_cell_m", o.fine_cell_m, Range{0.2, 50}, "cells of the raster search [m]");
  field("coarse_cell_m", o.coarse_cell_m, Range{0.2, 200},
        "cells of its first look at large maps [m]");
  field("keep_cells", o.keep_cells, Range{0, 10000000},
        "best cells of the first look; 0 = by size of the map");
  field("keep_poses", o.keep_poses, Range{0, 100000},
        "distinct poses verified; 0 = by size of the map");
  field("refine_poses", o.refine_poses, Range{1, 100000}, "best of them refined to the end");
  field("negative_weight", o.negative_weight, Range{0, 10},
        "cost of a mapped object that should be seen but is not [nats]");
  field("negative_radius_m", o.negative_radius_m, Range{0, 50},
        "it should be seen this close to a query vertex [m]");
}

/// What may differ from query to query.
struct ObjectSearchRequest {
  PlacePrior prior;  ///< of the query origin, or of `focus` if given
  /// The point of the query that matters most, usually where the robot is now: the pose is refined
  /// with weights that fall with the distance to it (30 m), which takes out most of the odometry
  /// drift.
  std::optional<Eigen::Vector3d> focus;
  int hypotheses = 20;  ///< >= 1; of the best, told with all their details
  int threads = 1;
};

/// A pose and what speaks for it.
struct ObjectHypothesis {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  PlacePose centre;     ///< pose of the query centre in the map; its score is `score`
  double score = 0;     ///< log-likelihood ratio against chance [nats]
  double expected = 0;  ///< what the score would be on average were the pose true; score / expected
                        ///< is about 1 then
  double known_share = 0;  ///< share of the query's vertices that lie where the map knows anything
  std::vector<Correspondence>
      inliers;  ///< vertex pairs; similarity is the chance that the query vertex has a partner
};

/// How the wrong poses of the same search score.
struct WrongPoses {
  int count = 0;
  double mean = 0, deviation = 0;
  double best =
      0;  ///< the best pose more than 8 m or 0.4 rad from the first; meaningless if count is 0
};

struct ObjectSearchResult {
  std::vector<ObjectHypothesis> hypotheses;  ///< distinct poses, best first
  WrongPoses wrong;
  int poses = 0;     ///< distinct places verified
  int vertices = 0;  ///< of the query that take part: their class occurs in the map, and of the
                     ///< samples of a surface that say the same they are the best seen
};

class ObjectPlaceIndex {
 public:
  /// Vertices of ignored classes and without finite positions are left out; classes that `labels`
  /// does not know are objects. Surfaces are thinned to what is distinct from above, so that
  /// storeys of a facade count once; of a query whose vertices count their points, the worse seen
  /// half of each surface is left out as well.
  ObjectPlaceIndex(const SemanticGraph& map, const LabelSet& labels,
                   const ObjectPlaceOptions& options = {});
  ~ObjectPlaceIndex();
  ObjectPlaceIndex(ObjectPlaceIndex&&) noexcept;
  ObjectPlaceIndex& operator=(ObjectPlaceIndex&&) noexcept;

  /// Where does the query fit? Exhaustive over position and heading within the prior; gravity along
  /// z in both. Of queries larger than 400 m around, three dense parts are searched for and their
  /// best places tried on the whole. No hypothesis if nothing agrees (empty map or query, no common
  /// class).
  ObjectSearchResult search(const SemanticGraph& query,
                            const ObjectSearchRequest& request = {}) const;

  /// Verifies and refines poses that others propose, by the same measure. One result per pose, in
  /// the order given.
  std::vector<ObjectHypothesis> score(const SemanticGraph& query,
                                      const std::vector<Eigen::Isometry3d>& T_map_query,
                                      const ObjectSearchRequest& request = {}) const;

  std::size_t size() const;   ///< vertices of the map that take part
  std::size_t bytes() const;  ///< memory of the index

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace xview
