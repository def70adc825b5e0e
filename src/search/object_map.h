// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "xview/search/search.h"

namespace xview::search {

/// Values on an unbounded plane of cells; 32x32 cells at a time come into being when one is
/// written.
template <class Value>
class SparseGrid {
 public:
  /// Null if nothing was written near the cell.
  const Value* find(std::int64_t cx, std::int64_t cy) const {
    const auto it = tiles_.find(key(cx >> kBits, cy >> kBits));
    return it == tiles_.end() ? nullptr : &(*it->second)[cellInTile(cx, cy)];
  }

  Value& at(std::int64_t cx, std::int64_t cy) {
    const std::uint64_t wanted = key(cx >> kBits, cy >> kBits);
    if (!last_ || wanted != last_key_) {
      std::unique_ptr<Tile>& tile = tiles_[wanted];
      if (!tile) tile = std::make_unique<Tile>();
      last_ = tile.get();
      last_key_ = wanted;
    }
    return (*last_)[cellInTile(cx, cy)];
  }

 private:
  static constexpr int kBits = 5;
  static constexpr std::int64_t kSide = 1 << kBits;
  using Tile = std::array<Value, kSide * kSide>;

  static std::uint64_t key(std::int64_t tx, std::int64_t ty) {
    return (static_cast<std::uint64_t>(tx) << 32) | (static_cast<std::uint64_t>(ty) & 0xFFFFFFFFu);
  }
  static std::size_t cellInTile(std::int64_t cx, std::int64_t cy) {
    return static_cast<std::size_t>((cy & (kSide - 1)) * kSide + (cx & (kSide - 1)));
  }

  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  Tile* last_ = nullptr;
  std::uint64_t last_key_ = 0;
};

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
};

/// The map prepared for verification: points in blocks, tangents, densities.
class ObjectMap {
 public:
  ObjectMap(const SemanticGraph& graph, const LabelSet& labels, const SearchOptions& options);

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

 private:
  struct Range {
    std::uint32_t begin = 0, end = 0;
  };

  template <class Visitor>
  void visitBlocks(double x, double y, double half_side, const Visitor& visitor) const;
  void takeVertices(const SemanticGraph& graph, const LabelSet& labels,
                    const SearchOptions& options);
  void makeClasses(const LabelSet& labels, const std::vector<std::uint32_t>& label_of_slot,
                   const SearchOptions& options);
  void sortIntoBlocks();
  void measureSpacing();
  void weighSurfaces();
  bool goesOn(const MapPoint& point, const Eigen::Vector2d& direction, double metres) const;
  void measureDensities();
  void drawCoverage(double reach_m);
  void findTangents();
  void findTangent(MapPoint& point, double radius) const;

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

}  // namespace xview::search
