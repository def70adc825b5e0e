// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/cells.h"
#include "base/stored_vertices.h"
#include "search/search.h"

namespace xview::search {

/// The cell of a point in the plane; beyond a billion cells whatever is there shares one.
inline PlaneCell cellAt(double x, double y, double side) {
  const auto index = [side](double v) {
    return static_cast<std::int32_t>(std::clamp(std::floor(v / side), -1e9, 1e9));
  };
  return {index(x), index(y)};
}

/// Calls visit(cell) for those that a square touches, row by row.
template <class Visit>
void forSquare(double x, double y, double half_side, double side, const Visit& visit) {
  const PlaneCell low = cellAt(x - half_side, y - half_side, side),
                  high = cellAt(x + half_side, y + half_side, side);
  for (PlaneCell cell = low; cell.y <= high.y; ++cell.y) {
    for (cell.x = low.x; cell.x <= high.x; ++cell.x) visit(cell);
  }
}

/// Samples of a surface this far apart are independent evidence [m].
constexpr double kIndependentM = 6;
/// Factors on the chance to find an object again: for things that move between visits, and for
/// vertices of surfaces, which depend on the view.
constexpr double kDynamicDetection = 0.7, kSurfaceDetection = 0.65;
/// Error of a vertex of a surface across it, map and query together [m].
constexpr double kSurfaceSigma_m = 1.2;
/// A query should see objects of the map that are this close to one of its vertices [m]; what one
/// costs that it does not see [nats].
constexpr double kSeenNear_m = 8.5, kUnseenWeight = 0.5;

/// What is assumed about one class. Slots number the classes of the map.
struct ObjectClass {
  std::uint32_t label = 0;
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

  bool hasTangent() const { return tangent_x != 0 || tangent_y != 0; }
};

/// The map prepared for verification: points in blocks, tangents, densities.
class ObjectMap {
 public:
  ObjectMap(const AllVertices& vertices, const LabelSet& labels, const SearchOptions& options);

  const Eigen::Vector3d& origin() const { return origin_; }
  const std::vector<ObjectClass>& classes() const { return classes_; }
  const std::vector<MapPoint>& points() const { return points_; }
  std::optional<std::uint16_t> slotOf(std::uint32_t label) const;
  /// log of the expected vertices of the class per square metre of clutter: the mean of here (48 x
  /// 48 m) and everywhere.
  double logClutter(std::uint16_t slot, double x, double y) const;
  /// True where the map knows anything within about 30 m.
  bool isKnown(double x, double y) const;
  /// How surely an object at each of these places would be in the map, had it been there: 1 some
  /// metres from a vertex of the map, 0 far from all. Drawn where it is asked for. Thread-safe.
  void coverage(const std::vector<Eigen::Vector2d>& places, std::vector<double>& result) const;
  /// False if all heights of the map are equal: it has none.
  bool hasHeights() const { return has_heights_; }
  /// Calls visit(index) for the points of all blocks of 32 m that a square touches, block by block.
  template <class Visitor>
  void visitBlocks(double x, double y, double half_side, const Visitor& visit) const {
    forSquare(x, y, half_side, kBlock_m, [&](const PlaneCell& block) { visitBlock(block, visit); });
  }
  template <class Visitor>
  void visitBlock(const PlaneCell& block, const Visitor& visit) const {
    const Range range = blocks_(block);
    for (std::uint32_t i = range.begin; i < range.end; ++i) visit(i);
  }
  static constexpr double kBlock_m = 32;
  /// Indices of the points in a square.
  void pointsIn(double x, double y, double half_side, std::vector<std::uint32_t>& found) const;

 private:
  struct Range {
    std::uint32_t begin = 0, end = 0;
  };

  void takeVertices(const AllVertices& vertices, const LabelSet& labels,
                    const SearchOptions& options);
  void makeClasses(const LabelSet& labels, const std::vector<std::uint32_t>& label_of_slot,
                   const SearchOptions& options);
  void sortIntoBlocks();
  void measureSpacing();
  void weighSurfaces();
  bool goesOn(const MapPoint& point, const Eigen::Vector2d& direction, double metres) const;
  void measureDensities();
  void findTangents();
  void findTangent(MapPoint& point, double radius) const;

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<ObjectClass> classes_;
  std::map<std::uint32_t, std::uint16_t> slot_of_label_;
  std::vector<MapPoint> points_;
  TilePlane<Range> blocks_;
  std::vector<TilePlane<std::uint16_t>>
      counts_;  ///< per slot: vertices in the 3x3 density cells around
  TilePlane<std::uint8_t> known_;
  bool has_heights_ = false;
  static constexpr double kCovered_m = 4;    ///< side of a cell of coverage_
  using Coverage = TilePlane<std::uint8_t>;  ///< in steps of 1 / 255
  void cover(Coverage::Tile& tile) const;
  mutable std::mutex covering_;
  mutable Coverage coverage_;
};

/// log(1 + exp(v)), from a table: good to 1e-3.
double softplus(double v);

}  // namespace xview::search
