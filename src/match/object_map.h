// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "sparse_grid.h"
#include "xview/match/object_places.h"
#include "xview/match/raster_search.h"

namespace xview {

/// Samples of a surface this far apart are independent evidence [m].
constexpr double kIndependentM = 6;

/// What is assumed about one class. Slots number the classes of the map.
struct ObjectClass {
  std::uint32_t label = 0;
  Kind kind = Kind::other_object;
  bool is_surface = false;  ///< sampled along lines; else every vertex is a thing
  double spacing_m = 0;     ///< of surface vertices in the map
  double detection = 0;     ///< P_D
  double log_miss = 0;      ///< log(1 - P_D)
  double along_m = 0;       ///< standard deviation along the tangent; objects: in all directions
  double across_m = 0;      ///< across it
  double height_m = 0.5;    ///< standard deviation of height differences of pairs
  double weight = 1;        ///< neighbouring samples of a surface are one piece of evidence
  double independence =
      1;  ///< below 1 where samples of a surface lie so near that they say the same
  double gain_weight = 1;   ///< the same for samples that agree: a surface that goes on and on does
                            ///< not tell where along it one is
  double mean_density = 0;  ///< around places of the map [1/m^2]
  std::vector<float> log_clutter;  ///< log of the clutter density by number of vertices around
  std::vector<std::uint16_t> confused_with;  ///< slots
};

/// log of P_D N(0) / ((1 - P_D) rho): the evidence of a perfect hit. The Gaussian has the area
/// along * across.
double logGain(const ObjectClass& model, double area, double log_clutter);

/// A vertex of the map, relative to the origin of the index.
struct MapPoint {
  float x, y, z;
  float tangent_x, tangent_y;  ///< unit vector along the surface; (0, 0) = unknown or an object
  float odds;                  ///< P_D N(0) / ((1 - P_D) rho): that a perfect hit is no coincidence
  std::uint32_t vertex;
  std::uint16_t slot;
};

/// The map prepared for verification: points in blocks, tangents, densities.
class ObjectMap {
 public:
  ObjectMap(const SemanticGraph& graph, const LabelSet& labels, const ObjectPlaceOptions& options);

  const Eigen::Vector3d& origin() const { return origin_; }
  const std::vector<ObjectClass>& classes() const { return classes_; }
  const std::vector<MapPoint>& points() const { return points_; }
  std::optional<std::uint16_t> slotOf(std::uint32_t label) const;
  /// log of the expected vertices of the class per square metre of clutter: the mean of here (48 x
  /// 48 m) and everywhere.
  double logClutter(std::uint16_t slot, double x, double y) const;
  /// True where the map knows anything within about 30 m.
  bool isKnown(double x, double y) const;
  /// How surely an object at this place would be in the map, had it been there: 1 some metres from
  /// a vertex of the map, 0 far from all.
  double coverage(double x, double y) const;
  /// False if all heights of the map are equal: it has none.
  bool hasHeights() const { return has_heights_; }
  /// Indices of the points in a square.
  void pointsIn(double x, double y, double half_side, std::vector<std::uint32_t>& found) const;
  std::size_t bytes() const;

 private:
  struct Range {
    std::uint32_t begin = 0, end = 0;
  };

  void takeVertices(const SemanticGraph& graph, const LabelSet& labels,
                    const ObjectPlaceOptions& options);
  void makeClasses(const LabelSet& labels, const std::vector<std::uint32_t>& label_of_slot,
                   const ObjectPlaceOptions& options);
  void sortIntoBlocks();
  void measureSpacing(const ObjectPlaceOptions& options);
  void weighSurfaces();
  bool goesOn(const MapPoint& point, const Eigen::Vector2d& direction, double metres) const;
  void measureDensities();
  void drawCoverage(double reach_m);
  void findTangents();
  bool tangentFrom(MapPoint& point, double radius, bool own_class_only) const;
  void findConfusions(const ObjectPlaceOptions& options);

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<ObjectClass> classes_;
  std::map<std::uint32_t, std::uint16_t> slot_of_label_;
  std::vector<MapPoint> points_;
  SparseGrid<Range> blocks_;
  std::vector<SparseGrid<std::uint16_t>>
      counts_;  ///< per slot: vertices in the 3x3 density cells around
  SparseGrid<std::uint8_t> known_;
  SparseGrid<std::uint8_t> coverage_;  ///< in steps of 1 / 255
  bool has_heights_ = false;
};

/// log(1 + exp(v)), from a table: good to 1e-3.
double softplus(double v);

}  // namespace xview
