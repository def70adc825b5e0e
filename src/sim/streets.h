// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace xview {

/// What stands on the lots of a town.
enum class Lots { houses, halls };

/// Shape of a simulated town. The seed decides everything that the fields leave open.
struct TownOptions {
  std::uint64_t seed = 1;
  std::uint64_t pattern_seed = 1;  ///< decides what alike streets and lots look like
  double alike = 0;                ///< share of the streets and lots that follow the pattern
  double winding_m = 0;            ///< streets swing by this to both sides
  Lots lots = Lots::houses;

  int blocks_x = 4, blocks_y = 4;  ///< blocks of houses from west to east, from south to north
  double street_spacing_m = 75;    ///< mean distance of crossings
  double irregularity = 0.6;       ///< 0 = straight grid, 1 = crooked, missing and slanting streets
  double relief_m = 2.5;           ///< hills rise and fall by up to this
  double house_density = 0.85;     ///< share of the lots with a house
  double row_share = 0.25;         ///< of the street sides: houses all alike, at equal distances
  double tree_density = 1;         ///< factor on the number of trees
  double car_density = 0.25;       ///< share of the parking places taken
  bool hedges_apart = false;       ///< hedges are a class of their own
};

using Polyline = std::vector<Eigen::Vector2d>;

struct Street {
  int from = -1;  ///< junction; -1 for a cul-de-sac that leaves another street half-way
  int to = -1;
  Polyline centreline;
  double half_width_m = 3;  ///< of the road
  double sidewalk_m = 2;    ///< width beyond the road, either side
  bool isThrough() const { return from >= 0; }
};

struct Junction {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  std::vector<int> streets;  ///< through streets that end here, sorted
};

/// Junctions and the streets between them. Through streets form one connected network in which
/// every junction has at least two of them, so that a drive never needs to turn round.
struct StreetNetwork {
  std::vector<Junction> junctions;
  std::vector<Street> streets;
};

StreetNetwork makeStreets(const TownOptions& options);

/// A point of a polyline with its direction; `along_m` is clamped to its length.
struct PolylinePoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  Eigen::Vector2d left() const { return {-direction.y(), direction.x()}; }
};

/// Positions by distance along a polyline of at least two points.
class ArcLength {
 public:
  explicit ArcLength(const Polyline& line);
  double length() const { return along_.back(); }
  PolylinePoint at(double along_m) const;

 private:
  Polyline line_;
  std::vector<double> along_;  ///< of each point
};

/// Signed distances to the edges of roads and sidewalks, negative on them. Where two streets meet,
/// the edges are rounded. Far from every street the distance saturates at kFar.
class StreetField {
 public:
  static constexpr double kFar = 12;

  explicit StreetField(const StreetNetwork& network);
  /// A paved way outside the streets, e.g. to a garage; counts as sidewalk.
  void addPath(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half_width_m);

  double toRoad(const Eigen::Vector2d& p) const;
  double toSidewalk(const Eigen::Vector2d& p) const;
  const Eigen::AlignedBox2d& bounds() const { return bounds_; }  ///< of the centre lines

 private:
  struct Segment {
    Eigen::Vector2d a, b;
    double road_m, sidewalk_m;  ///< half widths
    int street;
  };
  void addSegment(const Segment& segment);
  const std::vector<std::uint32_t>* bin(const Eigen::Vector2d& p) const;
  double distance(const Eigen::Vector2d& p, double Segment::*half_width) const;

  Eigen::AlignedBox2d bounds_;
  int bins_x_ = 0, bins_y_ = 0;
  std::vector<Segment> segments_;
  std::vector<std::vector<std::uint32_t>> bins_;  ///< segments within reach of each bin, in order
};

}  // namespace xview
