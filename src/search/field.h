// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "base/stored_vertices.h"
#include "base/stored_view.h"
#include "search/likelihoods.h"
#include "xview/base/bev_grid.h"
#include "xview/base/graph.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"

namespace xview::search {

/// The parts of a query that a field is evaluated for, in a gravity-aligned frame. They must
/// outlive the FieldQuery that is made of them.
struct Observation {
  const BevGrid* bev = nullptr;          ///< for surface fields
  const SemanticGraph* graph = nullptr;  ///< for object fields
  /// The point of the query that priors speak of, usually where the robot is now: they hold for it,
  /// whatever the odometry did before. None = priors speak of the origin
  /// of the query.
  std::optional<Eigen::Vector3d> focus;
};

/// Log-likelihood ratio of a part of a query at a pose, and its mean at a true one [nats].
struct PartScore {
  double score = 0, expected = 0;
};

/// A pose and its evidence.
struct PlaceHypothesis {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  PlacePose centre;          ///< where it puts the centre of the query in the map; with the score
  double expected = 0;       ///< score that a true pose would have on average [nats]
  double map_coverage = 0;   ///< share of the query that falls where the map knows anything
  PartScore obstacles;       ///< upright surfaces and obstacles; surface fields only
  bool of_surfaces = false;  ///< bird's-eye views were compared, not vertices
  int storey = 0;            ///< counted from below, if the field has several
  int matched = 0;           ///< objects (or vertices) of the query that have a partner
  /// Vertex pairs; similarity is the chance that the query vertex has a partner. Object fields
  /// only.
  std::vector<Correspondence> pairs;

  double score() const { return centre.score; }  ///< log-likelihood ratio against chance [nats]
};

/// How the heights of the map lie against those of a query under a pose:
/// z_map = z_query + height_m + slope . (p - p_centre), in map axes about the query centre.
struct HeightFit {
  double height_m = 0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();       ///< [m/m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of height and slope
  int cells = 0;  ///< of ground that agree; 0 = too few to tell
};

/// What one sample of a query says about a pose.
struct SampleEvidence {
  BevChannel channel = BevChannel::road;
  Eigen::Vector2d query = Eigen::Vector2d::Zero();  ///< in the query frame [m]
  Eigen::Vector2d map = Eigen::Vector2d::Zero();    ///< where the pose puts it in the map [m]
  bool known = false;                               ///< the map was seen there
  double nats = 0;                                  ///< contribution to the score of the pose
  double expected = 0;  ///< contribution that a true pose would have on average; 0 if not known
};

struct RasterLevels;
struct SearchOptions;

/// Level of the local refinement of a pose.
enum class RefinementLevel {
  rough,   ///< a first step from a cell of the raster search, to tell which cells are worth more
  coarse,  ///< from a cell of the raster search to where scores can be compared
  fine,    ///< from there to the local maximum
  polish   ///< of poses that are reported: more exact than comparing needs
};

/// A query in one field: the log-likelihood ratio of any of its poses. Thread-safe; the field
/// and what the observation points to must outlive it.
class FieldQuery {
 public:
  virtual ~FieldQuery() = default;

  /// Samples or vertices that take part; 0 = the field cannot say anything about the query.
  virtual std::size_t size() const = 0;
  bool empty() const { return size() == 0; }
  /// The middle of it in the query frame; its height is that of the ground, if that is known.
  const Eigen::Vector3d& centre() const { return centre_; }
  double radius() const { return radius_; }  ///< of all that takes part, around the centre [m]
  /// The point that priors speak of.
  const Eigen::Vector3d& focus() const { return focus_; }

  /// What lies within `radius_m` of a point of the query frame, as a query of its own.
  virtual std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& centre,
                                           double radius_m) const = 0;

  /// The query in the storey in which a pose puts it: itself if there is one storey only.
  virtual const FieldQuery& at(const Eigen::Isometry3d& /*T_map_query*/) const { return *this; }
  /// The query in each storey, from below.
  virtual std::vector<const FieldQuery*> storeys() const { return {this}; }
  int storey() const { return storey_; }  ///< that it is in, counted from below
  void setStorey(int storey) { storey_ = storey; }

  /// The score of a gravity-aligned pose [nats].
  double score(const Eigen::Isometry3d& T_map_query) const;
  /// What speaks for a pose. It stays where it is in the plane; height and tilt are found anew.
  PlaceHypothesis describe(const Eigen::Isometry3d& T_map_query) const;
  /// The best pose around a proposed one, some metres away at most.
  PlaceHypothesis verify(const Eigen::Isometry3d& T_map_query) const;
  /// How the ground lies under a pose. `slope_sigma`: how far off level the query may be [m/m].
  virtual HeightFit fitHeights(const Eigen::Isometry3d& T_map_query, double slope_sigma) const;
  /// What the score of a pose is the sum of, by sample; surface fields only.
  virtual std::vector<SampleEvidence> evidence(const Eigen::Isometry3d& T_map_query) const;
  /// Overlaps and conflicts of query and map; surface fields only.
  virtual Visibility visibility(const Eigen::Isometry3d& T_map_query) const;

  // What search() works with: poses of the centre, relative to the origin of the field.
  struct Point {
    Eigen::Vector2d p;  ///< in the query frame [m]
    double weight = 1;
  };
  /// All that takes part, and how much it tells places apart.
  virtual std::vector<Point> points() const = 0;
  virtual RasterLevels rasterLevels() const = 0;
  /// With cells half as wide, for a query whose true pose may have been missed; null if there
  /// are none.
  virtual std::unique_ptr<RasterLevels> finerLevels() const;
  /// The local maximum of the score near a pose, as exact as the level says.
  virtual PlacePose refineLocally(const PlacePose& centre_pose, RefinementLevel how) const = 0;
  virtual double scoreAt(const PlacePose& centre_pose) const = 0;
  virtual PlaceHypothesis describeAt(const PlacePose& centre_pose) const = 0;
  const Eigen::Vector3d& origin() const { return origin_; }  ///< in the map frame
  PlacePose centrePose(const Eigen::Isometry3d& T_map_query) const;
  /// The pose in the plane and its score; `height_m` is that of the centre above the map's zero.
  PlaceHypothesis inMap(const PlacePose& centre_pose, double height_m = 0) const;

 protected:
  /// `origin`: of the poses of search(), in the map frame.
  FieldQuery(const Eigen::Vector3d& origin, const std::optional<Eigen::Vector3d>& focus)
      : origin_(origin), focus_(focus.value_or(Eigen::Vector3d::Zero())) {}

  Eigen::Vector3d origin_, focus_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0;
  int storey_ = 0;
};

/// What a place says about any query at any pose. Thread-safe.
class Field {
 public:
  virtual ~Field() = default;
  virtual std::unique_ptr<FieldQuery> prepare(const Observation& query) const = 0;
  virtual std::size_t size() const = 0;  ///< tiles or vertices; 0 = nothing is known
  bool empty() const { return size() == 0; }
  /// What was counted along the path of the map; nothing of a bare graph.
  virtual PathNull pathNull() const { return {}; }
};

/// Surroundings of a robot: between the houses of a town a query observes the obstacles of the map,
/// in rooms furniture occludes most of them, so that missing obstacles say nothing there.
enum class Surroundings { town, rooms };

struct MapOverview;

/// The bird's-eye view of a map: all of it, or one that is read where somebody looks.
struct MapView {
  MapView(const BevGrid& whole) : grid(whole) {}  // NOLINT: any grid is one
  /// `grid`: without samples if there is a stored view, of which null counts and the overview must
  /// be known.
  MapView(const BevGrid& of, std::shared_ptr<const StoredView> view,
          std::shared_ptr<const MapOverview> seen_from_afar)
      : grid(of), stored(std::move(view)), overview(std::move(seen_from_afar)) {}

  const BevGrid& grid;
  std::shared_ptr<const StoredView> stored;
  std::shared_ptr<const MapOverview> overview;
};

/// Surfaces and objects of BEV grids, compared by learned likelihoods of their distances.
/// `trajectory`: positions of the sensor when the map was made, in order; what wrong places look
/// like is counted along the part of it that `known` does not cover.
std::unique_ptr<const Field> makeSurfaceField(const MapView& map,
                                              const std::vector<Eigen::Vector3d>& trajectory,
                                              Surroundings surroundings, const PathNull& known,
                                              const SearchOptions& options, int threads);

/// A field that holds above a height of the map, up to the next one.
struct FieldAbove {
  double bottom = 0;
  std::unique_ptr<const Field> field;
  std::shared_ptr<const BevGrid> view;  ///< what the field refers to
};
/// Storeys of a building, from below, as one field: a search looks in each of them, a pose is asked
/// of where it lies.
std::unique_ptr<const Field> makeStackedField(std::vector<FieldAbove> storeys);

/// A bare semantic graph: vertices with a class and nothing else. Densities and the spacing of
/// surface vertices come from the map, so any set of classes will do. Vertices of ignored classes
/// and without finite positions are left out; classes that `labels` does not know are objects.
/// Surfaces are thinned to what is distinct from above, so that storeys of a facade count once; of
/// a query whose vertices count their points, the half of each surface with fewer points is left
/// out, too.
std::unique_ptr<const Field> makeObjectField(const AllVertices& map, const LabelSet& labels,
                                             const SearchOptions& options);

}  // namespace xview::search
