// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "xview/sim/town_options.h"

namespace xview {

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
