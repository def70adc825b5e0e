// SPDX-License-Identifier: BSD-3-Clause
#include "sim/office.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/pose.h"
#include "furniture.h"
#include "sim/route.h"

namespace xview {
namespace {

using namespace office_class;

constexpr double kHeight = 2.7, kWall = 0.12;            // of storey and walls [m]
constexpr double kDoorWidth = 0.95, kDoorHeight = 2.05;  // [m]
constexpr double kTurn_rad = 15 * M_PI / 180;            // between poses that turn on the spot
constexpr double kVisited = 0.5;                         // share of the open doors

/// Builds walls, rooms and corridors from south to north.
class FloorBuilder {
 public:
  explicit FloorBuilder(const OfficeOptions& options) { office_.options = options; }

  Office build() {
    const OfficeOptions& o = office_.options;
    for (int y = 0; y < o.blocks_y; ++y) {
      for (int x = 0; x < o.blocks_x; ++x) addBlock(x, y);
    }
    addShell();
    addCorridors();
    return std::move(office_);
  }

 private:
  double blockLength() const { return office_.options.rooms * office_.options.room_width_m; }
  Eigen::Vector2d pitch() const {
    const OfficeOptions& o = office_.options;
    return {blockLength() + o.corridor_m, 2 * o.room_depth_m + o.corridor_m};
  }
  Eigen::Vector2d cornerOf(int x, int y) const {
    return pitch().cwiseProduct(Eigen::Vector2d(x, y));
  }

  /// A wall between two points from `low` to `high` metres above the floor.
  void addWall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double low = 0,
               double high = kHeight) {
    const Eigen::Vector2d along = b - a;
    if (along.norm() < 0.02) return;
    const Eigen::Vector2d middle = (a + b) / 2;
    addBox(office_.mesh,
           poseFromYaw({middle.x(), middle.y(), low}, std::atan2(along.y(), along.x())),
           {along.norm() + kWall * 0.98, kWall, high - low}, office_.tags.next(kWallClass));
  }

  void addBlock(int x, int y) {
    const OfficeOptions& o = office_.options;
    const Eigen::Vector2d corner = cornerOf(x, y);
    const double length = blockLength(), depth = o.room_depth_m;
    addWall(corner, corner + Eigen::Vector2d(0, 2 * depth));
    addWall(corner + Eigen::Vector2d(length, 0), corner + Eigen::Vector2d(length, 2 * depth));
    addWall(corner + Eigen::Vector2d(0, depth), corner + Eigen::Vector2d(length, depth));
    for (int k = 0; k < 2 * o.rooms; ++k) {
      const bool north = k >= o.rooms;  // its door is on the northern side of the block
      const double along = (north ? 2 * o.rooms - k : k) * o.room_width_m;
      addRoom({corner + Eigen::Vector2d(along, north ? 2 * depth : 0), north ? M_PI : 0});
    }
  }

  /// Room frame: origin at a corner of its corridor wall, x along that wall, y into the room.
  struct RoomPlace {
    Eigen::Vector2d origin;
    double yaw;
    Eigen::Vector2d toWorld(const Eigen::Vector2d& p) const {
      return origin + Eigen::Rotation2Dd(yaw) * p;
    }
  };

  void addRoom(const RoomPlace& place) {
    const OfficeOptions& o = office_.options;
    const auto number = static_cast<std::uint64_t>(office_.doors.size());
    Random own(o.seed ^ 0x524F, number);
    const double door_at = own.uniform() < 0.5 ? 0.8 : o.room_width_m - 0.8;
    Door door;
    door.open = own.uniform() < 0.75;
    door.in_corridor = place.toWorld({door_at, -o.corridor_m / 2});
    door.in_room = place.toWorld({0.5 * (door_at + o.room_width_m / 2), 1.5});
    office_.doors.push_back(door);
    const double left = door_at - kDoorWidth / 2, right = door_at + kDoorWidth / 2;
    addWall(place.toWorld({0, 0}), place.toWorld({left - kWall / 2, 0}));
    addWall(place.toWorld({right + kWall / 2, 0}), place.toWorld({o.room_width_m, 0}));
    addWall(place.toWorld({left, 0}), place.toWorld({right, 0}), kDoorHeight);
    if (number % static_cast<std::uint64_t>(o.rooms) != 0)
      addWall(place.toWorld({0, 0}), place.toWorld({0, o.room_depth_m}));
    // The leaf opens towards the nearer wall, out of the way.
    const bool is_left = door_at < o.room_width_m / 2;
    const Eigen::Vector2d hinge = place.toWorld({is_left ? left : right, 0});
    const double angle = door.open ? own.uniform(1.4, 2) : 0;
    const Eigen::Isometry3d T_hinge =
        poseFromYaw({hinge.x(), hinge.y(), 0}, place.yaw + (is_left ? angle : M_PI - angle));
    addBox(office_.mesh, T_hinge * Eigen::Translation3d(kDoorWidth / 2, 0, 0),
           {kDoorWidth - 0.04, 0.05, kDoorHeight - 0.02}, office_.tags.next(kDoor));

    const bool follows = o.alike > 0 && own.uniform() < o.alike;
    Random random = follows ? Random(o.pattern_seed ^ 0x524F, door_at < 1 ? 1 : 2) : own;
    Furnisher furnisher(office_, {{o.room_width_m, o.room_depth_m}, kWall, kHeight},
                        poseFromYaw({place.origin.x(), place.origin.y(), 0}, place.yaw), random);
    furnisher.keepFree({{door_at, 1.0}, 0, {1.3, 2.0}});
    furnisher.keepFree({{0.5 * (door_at + o.room_width_m / 2), 1.5}, 0, {1.3, 1.3}});
    furnisher.furnishRoom();
    office_.floor_space.push_back({place.toWorld({o.room_width_m / 2, o.room_depth_m / 2}),
                                   place.yaw,
                                   {o.room_width_m - 1, o.room_depth_m - 1}});
  }

  /// Outer walls, floor, ceiling.
  void addShell() {
    const OfficeOptions& o = office_.options;
    const Eigen::Vector2d low = Eigen::Vector2d::Constant(-o.corridor_m);
    const Eigen::Vector2d high = cornerOf(o.blocks_x, o.blocks_y);
    const Eigen::Vector2d corners[] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    for (int i = 0; i < 4; ++i) addWall(corners[i], corners[(i + 1) % 4]);
    const auto plate = [&](double z, std::uint16_t label) {
      addQuad(office_.mesh, {low.x(), low.y(), z}, {high.x(), low.y(), z}, {high.x(), high.y(), z},
              {low.x(), high.y(), z}, {label, 0});
    };
    plate(0, kFloor);
    plate(kHeight, kCeiling);
  }

  /// Corridors between and around the blocks, with what stands and hangs there.
  void addCorridors() {
    const OfficeOptions& o = office_.options;
    StreetNetwork& network = office_.corridors;
    const auto junction = [&](int x, int y) { return y * (o.blocks_x + 1) + x; };
    for (int y = 0; y <= o.blocks_y; ++y) {
      for (int x = 0; x <= o.blocks_x; ++x)
        network.junctions.push_back(
            {cornerOf(x, y) - Eigen::Vector2d::Constant(o.corridor_m / 2), {}});
    }
    for (int y = 0; y <= o.blocks_y; ++y) {
      for (int x = 0; x <= o.blocks_x; ++x) {
        if (x < o.blocks_x) addCorridor(junction(x, y), junction(x + 1, y));
        if (y < o.blocks_y) addCorridor(junction(x, y), junction(x, y + 1));
      }
    }
  }

  void addCorridor(int from, int to) {
    StreetNetwork& network = office_.corridors;
    const Eigen::Vector2d a = network.junctions[from].position, b = network.junctions[to].position;
    const auto number = static_cast<int>(network.streets.size());
    Street corridor;
    corridor.from = from;
    corridor.to = to;
    corridor.centreline = {a, b};
    network.streets.push_back(corridor);
    for (const int end : {from, to}) network.junctions[end].streets.push_back(number);

    const OfficeOptions& o = office_.options;
    const double length = (b - a).norm(), yaw = std::atan2(b.y() - a.y(), b.x() - a.x());
    const Footprint space{(a + b) / 2, yaw, {length, o.corridor_m}};
    const Eigen::Vector2d origin = space.toWorld({-length / 2, -o.corridor_m / 2});
    Random random(o.seed ^ 0x434F, static_cast<std::uint64_t>(number));
    Furnisher furnisher(office_, {{length, o.corridor_m}, kWall, kHeight},
                        poseFromYaw({origin.x(), origin.y(), 0}, yaw), random);
    // Things stay at the walls, and away from doors and crossings.
    furnisher.keepFree({{length / 2, o.corridor_m / 2}, 0, {length, o.corridor_m - 0.9}});
    for (const double end : {0.0, length})
      furnisher.keepFree({{end, o.corridor_m / 2}, 0, {o.corridor_m + 0.4, o.corridor_m}});
    for (const Door& door : office_.doors) {
      const Eigen::Vector2d p = Eigen::Rotation2Dd(-yaw) * (door.in_corridor - origin);
      if (std::abs(p.y() - o.corridor_m / 2) < 0.1)
        furnisher.keepFree({p, 0, {kDoorWidth + 0.3, o.corridor_m}});
    }
    furnisher.furnishCorridor();
    office_.floor_space.push_back({space.center, yaw, {length - 2, o.corridor_m - 1.2}});
  }

  Office office_;
};

/// Walks from point to point, straight on and turning on the spot.
class Walker {
 public:
  Walker(double spacing_m, std::vector<Eigen::Isometry3d>& poses)
      : spacing_m_(spacing_m), poses_(poses) {}

  void walkTo(const Eigen::Vector2d& goal) {
    if (!at_) {
      at_ = goal;
      return;
    }
    const Eigen::Vector2d way = goal - *at_;
    if (way.norm() < 1e-6) return;
    const double heading = std::atan2(way.y(), way.x());
    if (!poses_.empty()) turnBy(angleDifference(heading, yaw_));
    yaw_ = heading;
    if (poses_.empty()) stand();
    const int steps = std::max(1, static_cast<int>(std::lround(way.norm() / spacing_m_)));
    for (int i = 0; i < steps; ++i) {
      *at_ += way / steps;
      stand();
    }
  }

  void turnBy(double angle) {
    const int steps = static_cast<int>(std::ceil(std::abs(angle) / kTurn_rad - 1e-6));
    for (int i = 0; i < steps; ++i) {
      yaw_ += angle / steps;
      stand();
    }
  }

 private:
  void stand() { poses_.push_back(poseFromYaw({at_->x(), at_->y(), 0}, yaw_)); }

  double spacing_m_;
  std::vector<Eigen::Isometry3d>& poses_;
  std::optional<Eigen::Vector2d> at_;
  double yaw_ = 0;
};

struct WayPoint {
  Eigen::Vector2d p;
  bool look_around = false;
};

/// Doors that are visited on the way from a to b, in order.
std::vector<const Door*> visits(const Office& office, const Eigen::Vector2d& a,
                                const Eigen::Vector2d& b, Random& random) {
  const Eigen::Vector2d along = (b - a).normalized();
  const auto position = [&](const Door* door) { return along.dot(door->in_corridor - a); };
  std::vector<const Door*> chosen;
  for (const Door& door : office.doors) {
    const double s = position(&door);
    const bool is_here =
        s > 0 && s < (b - a).norm() && (door.in_corridor - a - s * along).norm() < 0.1 && door.open;
    if (is_here && random.uniform() < kVisited) chosen.push_back(&door);
  }
  std::sort(chosen.begin(), chosen.end(),
            [&](const Door* c, const Door* d) { return position(c) < position(d); });
  return chosen;
}

std::vector<WayPoint> planWay(const Office& office, double length_m, std::uint64_t seed) {
  Random random(seed, 11);
  const Polyline drive = streetsThrough(office.corridors, 1.2 * length_m, seed);
  std::vector<WayPoint> way{{drive.front()}};
  double walked = 0;
  for (std::size_t i = 1; i < drive.size() && walked < length_m; ++i) {
    const Eigen::Vector2d start = way.back().p;
    for (const Door* door : visits(office, drive[i - 1], drive[i], random)) {
      const double detour = (door->in_room - door->in_corridor).norm();
      if (walked + (door->in_corridor - start).norm() + detour > length_m) continue;
      way.insert(way.end(), {{door->in_corridor}, {door->in_room, true}, {door->in_corridor}});
      walked += 2 * detour;
    }
    walked += (drive[i] - start).norm();
    Eigen::Vector2d end = drive[i];
    if (walked > length_m) end -= (walked - length_m) * (end - drive[i - 1]).normalized();
    way.push_back({end});
  }
  return way;
}

}  // namespace

Office makeOffice(const OfficeOptions& options) { return FloorBuilder(options).build(); }

std::vector<Eigen::Isometry3d> planWalk(const Office& office, double length_m, double spacing_m,
                                        bool is_way_back, std::uint64_t seed) {
  std::vector<WayPoint> way = planWay(office, length_m, seed);
  if (is_way_back) std::reverse(way.begin(), way.end());
  std::vector<Eigen::Isometry3d> poses;
  Walker walker(spacing_m, poses);
  for (const WayPoint& point : way) {
    walker.walkTo(point.p);
    if (point.look_around) walker.turnBy(2 * M_PI);
  }
  return poses;
}

}  // namespace xview
