// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "search/object_map.h"
#include "search/raster.h"

namespace xview::search {

/// In the plane, a facade that is sampled in several storeys is one line, and a wall that was
/// taken for a hedge now and then is a wall. Of vertices of surfaces that say the same only the one
/// with the most points (then observations) stays: none has a better one of its class within 2.5 m
/// in the plane, nor one of another surface with several times its points within 2.5 m in space.
/// Returns indices, rising, of those vertices among `candidates` and of all that are no surfaces.
std::vector<std::uint32_t> distinctFromAbove(const SemanticGraph& graph,
                                             const std::vector<std::uint32_t>& candidates,
                                             const std::function<bool(std::uint32_t)>& is_surface);

/// Of a surface only the better seen half stays, those with at least as many points as is usual for
/// their class; the others are fragments and wrong labels as often as not. All that is no surface
/// stays, and all if points were not counted.
std::vector<std::uint32_t> wellSeen(const SemanticGraph& graph,
                                    std::vector<std::uint32_t> candidates,
                                    const std::function<bool(std::uint32_t)>& is_surface);

/// A query vertex relative to the centre of the query.
struct QueryItem {
  float x, y, z;
  std::uint16_t slot;
  std::uint32_t vertex;
};

/// Vertices of a query prepared for one map.
class ObjectQuery {
 public:
  /// `vertices` of the graph may take part: those that have a position and a class of the map do.
  ObjectQuery(const SemanticGraph& graph, const ObjectMap& map,
              const std::vector<std::uint32_t>& vertices);

  const std::vector<QueryItem>& items() const {
    return items_;
  }                                                          ///< rare classes first, surfaces last
  const Eigen::Vector3d& centre() const { return centre_; }  ///< in the frame of the query
  double radius() const { return radius_; }                  ///< [m]
  /// How much of this class the sensor of the query sees, compared to the map: 0 = nothing, 1 = as
  /// much as of the others.
  double visibleShare(std::uint16_t slot) const { return visible_[slot]; }
  /// False if all heights of the query are equal: it has none.
  bool hasHeights() const { return has_heights_; }
  /// How surely an object at this place (relative to the centre) would have been seen, were it of a
  /// visible class: 1 some metres from a vertex of the query, 0 far from all. Close to a vertex it
  /// says little as well: there the object may have been taken for that vertex.
  double expectsObject(double x, double y) const;
  /// The same for a sample of a surface: 0 if a sample of that surface was seen close by.
  double expectsSurface(std::uint16_t slot, double x, double y) const;
  /// For the raster search. Samples of a surface are thinned to about one per `gap_m`.
  std::vector<RasterSample> samples(const ObjectMap& map, double gap_m) const;
  /// How far from the centre the query has its nearest vertices [m].
  double emptyRadius() const;

 private:
  void findVisibleClasses(const ObjectMap& map);
  void drawCoverage(const ObjectMap& map, double reach_m);
  std::optional<std::size_t> coverageCell(double x, double y) const;

  std::vector<QueryItem> items_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0;
  std::vector<double> visible_;
  bool has_heights_ = false;
  double coverage_cell_ = 1;
  int coverage_side_ = 0;
  std::vector<float> nearest_;               ///< per cell: distance to the nearest vertex [m]
  std::vector<std::uint64_t> near_surface_;  ///< per cell: one bit per surface seen close by
  std::vector<std::uint8_t> surface_bit_;    ///< per slot
  double reach_ = 0;
};

}  // namespace xview::search
