// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/traffic.h"

#include <cmath>

#include "xview/sim/town_labels.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

void addCar(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_car, Random& random, Tag tag) {
  const bool van = random.uniform() < 0.15;
  const double length = van ? random.uniform(4.8, 5.6) : random.uniform(3.7, 4.8);
  const double width = random.uniform(1.65, 1.85), sill = 0.25;
  const double body = van ? 1.0 : random.uniform(0.5, 0.65), cabin = van ? 0.8 : 0.6;
  const Eigen::Isometry3d T_body = T_world_car * Eigen::Translation3d(0, 0, sill);
  addTaperedBox(mesh, T_body, {length, width, body}, {0.97, 0.95}, tag);
  const Eigen::Isometry3d T_cabin = T_body * Eigen::Translation3d(van ? -0.2 : -0.3, 0, body);
  addTaperedBox(mesh, T_cabin, {(van ? 0.85 : 0.6) * length, 0.93 * width, cabin}, {0.75, 0.85},
                tag);
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.5, 0.5}) {
      const Eigen::Vector3d hub(x * length, y * (width - 0.2), 0.3);
      addTube(mesh, T_world_car * (hub - Eigen::Vector3d(0, 0.1, 0)),
              T_world_car * (hub + Eigen::Vector3d(0, 0.1, 0)), 0.3, 0.3, 8, tag);
    }
  }
}

void addPerson(TriangleMesh& mesh, const Eigen::Vector3d& base, double yaw, Random& random,
               Tag tag) {
  const double height = random.uniform(1.5, 1.9);
  const Eigen::Isometry3d T = poseFromYaw(base, yaw);
  for (const double y : {-0.1, 0.1}) {
    addTube(mesh, T * Eigen::Vector3d(2 * y, y, 0), T * Eigen::Vector3d(0, y, 0.48 * height), 0.08,
            0.1, 5, tag);
  }
  addTube(mesh, T * Eigen::Vector3d(0, 0, 0.46 * height), T * Eigen::Vector3d(0, 0, 0.84 * height),
          0.17, 0.22, 7, tag);
  addLumpyEllipsoid(mesh, T * Eigen::Vector3d(0, 0, 0.92 * height), {0.11, 0.11, 0.14}, 0, random,
                    tag);
}

void addBicycle(TriangleMesh& mesh, const Eigen::Vector3d& base, double yaw, Tag tag) {
  const Eigen::Isometry3d T = poseFromYaw(base, yaw);
  const auto p = [&](double x, double z) { return T * Eigen::Vector3d(x, 0, z); };
  for (const double x : {-0.5, 0.5}) {
    addTube(mesh, T * Eigen::Vector3d(x, -0.02, 0.33), T * Eigen::Vector3d(x, 0.02, 0.33), 0.33,
            0.33, 10, tag);
  }
  addTube(mesh, p(-0.5, 0.33), p(-0.15, 0.9), 0.03, 0.03, 4, tag);
  addTube(mesh, p(-0.15, 0.8), p(0.4, 0.8), 0.03, 0.03, 4, tag);
  addTube(mesh, p(0.5, 0.33), p(0.38, 1.0), 0.03, 0.03, 4, tag);
  addTube(mesh, T * Eigen::Vector3d(0.38, -0.28, 1.0), T * Eigen::Vector3d(0.38, 0.28, 1.0), 0.03,
          0.03, 4, tag);
}

/// People and bicycles on the sidewalks of one street.
class SidewalkLife {
 public:
  SidewalkLife(TriangleMesh& mesh, const Town& town, TagSource& tags)
      : mesh_(mesh), town_(town), tags_(tags) {}

  void add(const Street& street, Random& random) {
    const ArcLength line(street.centreline);
    for (double s = random.uniform(0, 30); s < line.length(); s += random.uniform(8, 60)) {
      const double side = random.uniform() < 0.5 ? -1 : 1;
      const PolylinePoint p = line.at(s);
      const double out = street.half_width_m + street.sidewalk_m * random.uniform(0.3, 0.9);
      const Eigen::Vector2d place = p.position + side * out * p.left();
      const double yaw = std::atan2(p.direction.y(), p.direction.x()) + random.uniform(-0.3, 0.3);
      const Eigen::Vector3d base(place.x(), place.y(),
                                 groundHeight(town_.relief, town_.field, place));
      const bool person = random.uniform() < 0.7;
      if (town_.field.toRoad(place) < 0.3) continue;
      if (person) {
        addPerson(mesh_, base, yaw, random, tags_.next(town_class::kPedestrian));
      } else {
        addBicycle(mesh_, base, yaw, tags_.next(town_class::kBicycle));
      }
    }
  }

 private:
  TriangleMesh& mesh_;
  const Town& town_;
  TagSource& tags_;
};

}  // namespace

TriangleMesh makeTraffic(const Town& town, std::uint64_t day_seed) {
  TriangleMesh mesh;
  TagSource tags(town.last_instance);
  for (std::size_t i = 0; i < town.parking.size(); ++i) {
    Random random(day_seed ^ 0x4341, i);
    if (random.uniform() >= town.options.car_density) continue;
    const ParkingPlace& place = town.parking[i];
    const Eigen::Vector2d shift{random.uniform(-0.5, 0.5), random.uniform(-0.1, 0.1)};
    const Eigen::Vector2d p = place.position + Eigen::Rotation2Dd(place.yaw) * shift;
    const double turn = random.uniform() < 0.15 ? M_PI : random.uniform(-0.04, 0.04);
    const Eigen::Vector3d base(p.x(), p.y(), groundHeight(town.relief, town.field, p));
    addCar(mesh, poseFromYaw(base, place.yaw + turn), random, tags.next(town_class::kCar));
  }
  SidewalkLife life(mesh, town, tags);
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random(day_seed ^ 0x5057, i);
    life.add(town.network.streets[i], random);
  }
  return mesh;
}

}  // namespace xview
