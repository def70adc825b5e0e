// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "object_map.h"

namespace xview {

/// A query vertex relative to the centre of the query.
struct QueryItem {
  float x, y, z;
  std::uint16_t slot;
  std::uint32_t vertex;
};

/// A query prepared for one map.
class ObjectQuery {
 public:
  ObjectQuery(const SemanticGraph& graph, const ObjectMap& map, const ObjectPlaceOptions& options);

  const std::vector<QueryItem>& items() const {
    return items_;
  }                                                          ///< rare classes first, surfaces last
  const Eigen::Vector3d& centre() const { return centre_; }  ///< in the frame of the query
  double radius() const { return radius_; }                  ///< [m]
  /// True if the sensor of the query sees this class at all.
  bool isVisible(std::uint16_t slot) const { return visible_[slot] != 0; }
  /// True if the query was probably recorded from the air: nothing thin and upright, though the map
  /// has plenty.
  bool isFromAbove() const { return from_above_; }
  /// True close to a vertex, where other vertices should have been seen as well. Relative to the
  /// centre.
  bool covers(double x, double y) const;
  /// For the raster search. Samples of a surface are thinned to about one per `gap_m`.
  std::vector<RasterSample> samples(const ObjectMap& map, double gap_m) const;
  /// How far from the centre the query has its nearest vertices [m].
  double emptyRadius() const;

 private:
  void findVisibleClasses(const ObjectMap& map);
  void drawCoverage(double radius_m);

  std::vector<QueryItem> items_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0;
  std::vector<std::uint8_t> visible_;
  bool from_above_ = false;
  double coverage_cell_ = 1;
  int coverage_side_ = 0;
  std::vector<std::uint8_t> coverage_;
};

}  // namespace xview
