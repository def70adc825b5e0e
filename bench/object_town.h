// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview::bench {

// A town of objects without images, for questions about matching alone and for maps of millions of
// vertices. It repeats itself on purpose: trees, poles and parking bays stand at regular distances
// and whole streets look alike.

/// Classes of the town. Ids of objectTownLabels().
enum class TownClass : std::uint32_t { street = 1, building, tree, pole, car, fence, sign, hedge };

LabelSet objectTownLabels();

/// A thing of the town. Long things lie along `direction`, `half_length` to both sides.
struct TownObject {
  enum class Place : std::uint8_t { street_side, back_yard, parking_bay };
  float x = 0, y = 0, z = 0;                       ///< z of its foot [m]
  float half_length = 0;                           ///< [m]; 0 = point-like
  Eigen::Vector2f direction{0, 0}, outward{0, 0};  ///< along and away from the street
  float height = 0;                                ///< [m]
  float occupancy = 0;                             ///< of a parking bay: chance to hold a car
  float face = 0;                                  ///< uniform in [0, 1): decides who can see it
  TownClass label = TownClass::tree;
  Place place = Place::street_side;
};

/// A warped grid of streets_per_side x streets_per_side crossings, 60 to 130 m apart, with 13 % of
/// the streets missing and four styles of building that change every four blocks. About 450 objects
/// per km of street.
class ObjectTown {
 public:
  struct Street {
    std::uint32_t from, to;  ///< crossings
  };

  ObjectTown(int streets_per_side, std::uint64_t seed);

  const std::vector<TownObject>& objects() const { return objects_; }
  const std::vector<Street>& streets() const { return streets_; }
  const std::vector<Eigen::Vector2d>& crossings() const { return crossings_; }
  const std::vector<std::uint32_t>& streetsAt(std::uint32_t crossing) const {
    return streets_at_[crossing];
  }
  double streetLength() const;  ///< [m]
  std::uint64_t seed() const { return seed_; }
  double ground(double x, double y) const;
  /// Indices of objects in cells touched by the square of half side `radius` around (x, y), rising.
  void objectsNear(double x, double y, double radius, std::vector<std::uint32_t>& found) const;

 private:
  void makeCrossings(int n);
  void makeStreets(int n);
  void indexObjects();

  std::uint64_t seed_;
  std::vector<Eigen::Vector2d> crossings_;
  std::vector<Street> streets_;
  std::vector<std::vector<std::uint32_t>> streets_at_;
  std::vector<TownObject> objects_;
  double min_x_ = 0, min_y_ = 0;
  std::size_t cells_x_ = 0, cells_y_ = 0;
  std::vector<std::uint32_t> cell_start_, cell_object_;
};

/// What a recording gets wrong. Applies to the map and to the query.
struct TownNoise {
  double miss;         ///< chance that an object is not found
  double label_error;  ///< chance of a wrong class
  double sigma_m;      ///< of positions
  double spurious_per_100m;
  double car_change;  ///< share of parking bays that are drawn anew for each session
  double drift;       ///< of the odometry: relative length error; yaw drift is this per 20 m [rad]

  static TownNoise perfect() { return {0.10, 0.00, 0.3, 2, 0.3, 0.01}; }
  static TownNoise medium() { return {0.20, 0.05, 0.5, 5, 0.4, 0.01}; }
  static TownNoise noisy() { return {0.30, 0.10, 0.7, 8, 0.5, 0.01}; }
};

enum class TownView { forward, rear, aerial };

struct TownSampling {
  double surface_m = 3;  ///< spacing of the vertices of continuous classes
  double object_m = 2;   ///< objects of a class that are closer become one
};

/// The graph (without edges) of a drive through all streets with the camera forward. Vertices in
/// town coordinates.
SemanticGraph mapObjectTown(const ObjectTown& town, const TownNoise& noise,
                            const TownSampling& sampling, std::uint64_t session);

struct TownQuery {
  SemanticGraph graph;  ///< in an odometry frame of its own
  Eigen::Isometry3d T_map_query =
      Eigen::Isometry3d::Identity();  ///< upright; exact in the middle of the path
  Eigen::Vector3d last_in_query{0, 0, 0}, last_in_map{0, 0, 0};  ///< where the robot ends
};

/// `length_m` along random streets, with lane offset, odometry drift and a tilt of about a degree.
/// From the air poles and signs are invisible, roofs lie 5 m behind the facades and half the fences
/// are missed; back-yard trees appear.
TownQuery queryObjectTown(const ObjectTown& town, const TownNoise& noise,
                          const TownSampling& sampling, TownView view, double length_m,
                          std::uint64_t seed);

}  // namespace xview::bench
