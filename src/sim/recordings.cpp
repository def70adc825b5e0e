// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recordings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "base/option_field.h"
#include "sim/route.h"

namespace xview {
namespace {

constexpr double kLane = 1.4;     // from the middle of the road to the right [m]
constexpr double kWalking = 0.6;  // speed in an office [m/s]
constexpr double kTurn_s = 0.1;   // of the scanner
constexpr double kStart = 1.6e9;  // stamp of the first session [s]
constexpr double kFarAway = 1e5;  // truth of what is not in the map [m]
constexpr double kCameraHeight = 1.7, kLidarHeight = 1.8;
constexpr double kHandHeight = 1.15;                 // of sensors in an office [m]
constexpr double kNearest_m = 0.3, kFarthest_m = 8;  // of an RGB-D camera
constexpr std::uint64_t kElsewhere = 0x454C5345;

/// One of the recordings that can be made.
struct SessionKind {
  const char* name;
  bool wanted;
  std::uint64_t number;  ///< of its seed and of its day
  Sensor sensor;
  Mount mount;
  double left_m = -kLane;  ///< from the middle of the road
  bool is_way_back = false, is_elsewhere = false, is_bare = false;
  std::uint64_t drive = number;  ///< whose way, day and odometry it has

  /// Its odometry is as after optimisation.
  bool isMappingDrive() const { return drive == kForward || number == kLidar; }

  bool isAerial() const { return number == kAerial || number == kAerialElsewhere; }

  static constexpr std::uint64_t kForward = 0, kAerial = 5, kLidar = 7, kAerialElsewhere = 11;
};

Mount mountAt(double height_m, double yaw_rad = 0) {
  Mount mount;
  mount.height_m = height_m;
  mount.yaw_rad = yaw_rad;
  return mount;
}

Mount aerialMount(const AerialOptions& options) {
  Mount mount = mountAt(options.altitude_m);
  mount.pitch_rad = (90 - options.tilt_deg) * M_PI / 180;
  mount.sway_rad = 0.03;
  mount.follows_slope = false;
  mount.rise_m = 2;
  return mount;
}

std::vector<SessionKind> sessionKinds(const SimulationOptions& options) {
  const SessionChoice& choice = options.sessions;
  const Mount ahead = mountAt(kCameraHeight), scanner = mountAt(kLidarHeight);
  const Mount back = mountAt(kCameraHeight, M_PI), aside = mountAt(kCameraHeight, 0.9);
  const Mount aerial = aerialMount(options.aerial);
  const bool lidar_elsewhere = choice.lidar && choice.elsewhere,
             aerial_elsewhere = choice.aerial && choice.elsewhere;
  return {
      {"forward", true, SessionKind::kForward, Sensor::camera, ahead},
      {"forward2", choice.forward2, 1, Sensor::camera, ahead, -kLane + 0.25},
      {"rear", choice.rear, 2, Sensor::camera, back, -kLane - 0.15},
      {"rear_now", choice.rear_now, 12, Sensor::camera, back, -kLane, false, false, false,
       SessionKind::kForward},
      {"reverse", choice.reverse, 3, Sensor::camera, ahead, -kLane, true},
      {"oblique", choice.oblique, 4, Sensor::camera, aside},
      {"winter", choice.winter, 10, Sensor::camera, ahead, -kLane + 0.25, false, false, true},
      {"aerial", choice.aerial, SessionKind::kAerial, Sensor::camera, aerial, 3},
      {"lidar", choice.lidar, SessionKind::kLidar, Sensor::lidar, scanner},
      {"lidar_reverse", choice.lidar, 8, Sensor::lidar, scanner, -kLane, true},
      {"elsewhere", choice.elsewhere, 6, Sensor::camera, ahead, -kLane, false, true},
      {"lidar_elsewhere", lidar_elsewhere, 9, Sensor::lidar, scanner, -kLane, false, true},
      {"aerial_elsewhere", aerial_elsewhere, SessionKind::kAerialElsewhere, Sensor::camera, aerial,
       3, false, true},
  };
}

bool isOffice(const SimulationOptions& options) { return options.sim.style == "office"; }

/// Without what grows, and without small things.
TriangleMesh withoutLeaves(TriangleMesh mesh) {
  using namespace town_class;
  const auto isGone = [](const TriangleMesh::Triangle& triangle) {
    const std::uint16_t label = triangle.tag.label;
    return label == kVegetation || label == kHedge || label == kTrafficSign ||
           label == kPedestrian || label == kBicycle;
  };
  auto& all = mesh.triangles;
  all.erase(std::remove_if(all.begin(), all.end(), isGone), all.end());
  return mesh;
}

/// A world as the first drive and as all later ones see it.
struct TwoVisits {
  TriangleMesh before, after;
  std::vector<ObjectChange> changes;
};

/// Where a thing could stand instead, on the ground near a point of it; none if there is no room.
using PlaceNear = std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector3d&, Random&)>;

constexpr double kFoot_m = 0.35;  // what is no higher above the lowest point is the foot

/// A thing: its triangles and the classes of its parts.
struct Thing {
  std::vector<std::size_t> triangles;
  std::set<std::uint16_t> labels;
  std::optional<ObjectChange::What> change;
  Eigen::Vector3f shift = Eigen::Vector3f::Zero();  ///< of one that was moved
};

std::map<std::uint16_t, Thing> thingsOf(const TriangleMesh& world, const LabelSet& labels) {
  std::map<std::uint16_t, Thing> things;
  for (std::size_t i = 0; i < world.triangles.size(); ++i) {
    const Tag& tag = world.triangles[i].tag;
    if (tag.instance == 0 || labels.role(tag.label) != Role::object) continue;
    things[tag.instance].triangles.push_back(i);
    things[tag.instance].labels.insert(tag.label);
  }
  return things;
}

/// The middle of what of it is lowest.
Eigen::Vector3d footOf(const Thing& thing, const TriangleMesh& world) {
  float lowest = std::numeric_limits<float>::infinity();
  const auto forCorners = [&](const auto& visit) {
    for (const std::size_t t : thing.triangles)
      for (const std::uint32_t corner : world.triangles[t].corner) visit(world.vertices[corner]);
  };
  forCorners([&](const Eigen::Vector3f& p) { lowest = std::min(lowest, p.z()); });
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  forCorners([&](const Eigen::Vector3f& p) {
    if (p.z() > lowest + kFoot_m) return;
    sum += p.cast<double>();
    ++count;
  });
  return sum / count;
}

/// The triangles that `shows` wants, those of things that were moved where they are then.
template <class Shows>
TriangleMesh visitOf(const TriangleMesh& world, const std::map<std::uint16_t, Thing>& things,
                     bool is_later, Shows&& shows) {
  TriangleMesh mesh;
  mesh.vertices = world.vertices;
  for (const TriangleMesh::Triangle& triangle : world.triangles) {
    const auto found = things.find(triangle.tag.instance);
    const Thing* thing = found == things.end() ? nullptr : &found->second;
    if (!thing || !thing->change || thing->labels.count(triangle.tag.label) == 0) {
      mesh.triangles.push_back(triangle);
      continue;
    }
    if (!shows(*thing->change)) continue;
    TriangleMesh::Triangle placed = triangle;
    for (std::uint32_t& corner : placed.corner) {
      if (!is_later || thing->shift.isZero()) continue;
      mesh.vertices.push_back(world.vertices[corner] + thing->shift);
      corner = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    }
    mesh.triangles.push_back(placed);
  }
  return mesh;
}

/// Takes away, adds and moves a share of the things of object classes, a third each; a thing with
/// all of its parts, which are of one instance. Things that are added stand where the world has
/// them, and are missing before.
TwoVisits withChanges(TriangleMesh world, const LabelSet& labels, double share, std::uint64_t seed,
                      const PlaceNear& placeNear) {
  TwoVisits visits;
  std::map<std::uint16_t, Thing> things;
  if (share > 0) things = thingsOf(world, labels);
  for (auto& [instance, thing] : things) {
    Random random(seed ^ 0x4348, instance);
    if (random.uniform() >= share) continue;
    const Eigen::Vector3d foot = footOf(thing, world);
    thing.change = static_cast<ObjectChange::What>(random.below(3));
    Eigen::Vector3d to = foot;
    if (thing.change == ObjectChange::What::moved) {
      const auto place = placeNear(foot, random);
      if (place) {
        thing.shift = (*place - foot).cast<float>();
        to = *place;
      } else {
        thing.change = ObjectChange::What::gone;
      }
    }
    for (const std::uint16_t label : thing.labels)
      visits.changes.push_back({*thing.change, labels.className(label), foot, to});
  }
  using What = ObjectChange::What;
  if (visits.changes.empty()) {
    visits.before = std::move(world);
    return visits;
  }
  visits.before = visitOf(world, things, false, [](What what) { return what != What::added; });
  visits.after = visitOf(world, things, true, [](What what) { return what != What::gone; });
  return visits;
}

/// What stands somewhere, the way through it, and what a day brings.
struct World {
  const SimulationOptions& options;
  LabelSet labels;
  std::shared_ptr<const RayScene> before;  ///< what stands when it is mapped
  std::shared_ptr<const RayScene> after;   ///< and later, if that is something else
  std::shared_ptr<const RayScene> bare;    ///< and without leaves, if there is a winter
  std::vector<ObjectChange> changes;       ///< world frame
  /// Poses of the sensor's body in a session of this seed.
  std::function<std::vector<Eigen::Isometry3d>(const SessionKind&, std::uint64_t)> bodyPoses;
  std::function<TriangleMesh(std::uint64_t day_seed)> whatMoves;

  World(const SimulationOptions& o, LabelSet set, TwoVisits visits)
      : options(o), labels(std::move(set)), changes(std::move(visits.changes)) {
    if (o.sessions.winter)
      bare =
          std::make_shared<RayScene>(withoutLeaves(changes.empty() ? visits.before : visits.after));
    before = std::make_shared<RayScene>(std::move(visits.before));
    if (!changes.empty()) after = std::make_shared<RayScene>(std::move(visits.after));
  }

  std::uint64_t seedOf(std::uint64_t number) const {
    return Random(static_cast<std::uint64_t>(options.seed), 100 + number).next();
  }

  /// All but what the odometry says and the truth.
  SessionPlan plan(const SessionKind& kind) const {
    SessionPlan plan;
    plan.name = kind.name;
    plan.sensor = kind.sensor;
    plan.seed = seedOf(kind.number);
    plan.labels = labels;
    plan.T_world_sensor = bodyPoses(kind, seedOf(kind.drive));
    if (kind.sensor == Sensor::camera) {
      plan.camera = pinholeCamera(options.width, options.height, options.view_deg * M_PI / 180);
      plan.camera.depth_scale = 0.01;
      plan.depth_noise = options.depth_noise;
      if (kind.isAerial()) {
        plan.depth_noise.baseline_m = options.aerial.baseline_m;
      }
      for (Eigen::Isometry3d& T : plan.T_world_sensor) T = opticalPose(T);
    }
    if (isOffice(options)) {
      plan.camera.depth_scale = 0.001;
      plan.nearest_m = kNearest_m;
      plan.farthest_m = kFarthest_m;
      plan.speed = kWalking;
    }
    plan.start_s = kStart + 86400.0 * static_cast<double>(kind.drive);
    plan.period_s = options.frame_spacing_m / plan.speed;
    return plan;
  }

  std::unique_ptr<SimulatedRecording> record(const SessionKind& kind, SessionPlan plan) const {
    TriangleMesh moving = whatMoves(seedOf(kind.drive));
    if (kind.is_bare) moving = withoutLeaves(std::move(moving));
    const auto& what_stands = kind.is_bare                      ? bare
                              : kind.isMappingDrive() || !after ? before
                                                                : after;
    const Renderer renderer({what_stands, std::make_shared<RayScene>(std::move(moving))});
    return std::make_unique<SimulatedRecording>(std::move(plan), renderer, options);
  }
};

/// The options of a town or a floor of this world.
template <class Options>
Options seeded(Options options, const SimulationOptions& world, std::uint64_t seed) {
  options.seed = seed;
  options.pattern_seed = static_cast<std::uint64_t>(world.seed);
  options.alike = world.sim.alike;
  return options;
}

/// A place some metres away, on the ground beside the roads and not in a house.
std::optional<Eigen::Vector3d> roadsideNear(const Town& town, const Eigen::Vector3d& from,
                                            Random& random) {
  for (int i = 0; i < 20; ++i) {
    const double angle = random.uniform(-M_PI, M_PI), way_m = random.uniform(1.5, 5);
    const Eigen::Vector2d p =
        from.head<2>() + way_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const bool is_free =
        town.field.toRoad(p) > 0.25 &&
        std::none_of(town.houses.begin(), town.houses.end(),
                     [&](const Footprint& house) { return house.distanceTo(p) < 0.5; });
    // As deep in the ground as before.
    if (is_free) return from + town.onGround(p) - town.onGround(from.head<2>());
  }
  return std::nullopt;
}

/// A town that is driven through.
World drivenTown(const SimulationOptions& options, std::uint64_t seed) {
  TownOptions town_options = seeded(options.town, options, seed);
  town_options.hedges_apart = options.sim.hedges;
  const auto town = std::make_shared<Town>(makeTown(town_options));
  const auto near = [&](const Eigen::Vector3d& p, Random& random) {
    return roadsideNear(*town, p, random);
  };
  const LabelSet labels = townLabels(options.sim.hedges);
  World world(options, labels,
              withChanges(std::move(town->mesh), labels, options.sim.changed, seed, near));
  const Polyline drive = planDrive(town->network, options.route_length_m, seed);
  world.bodyPoses = [&options, town, drive](const SessionKind& kind, std::uint64_t session_seed) {
    const Polyline line = shifted(kind.is_way_back ? reversed(drive) : drive, kind.left_m);
    return bodyPoses(line, options.frame_spacing_m, kind.mount, town->relief, session_seed);
  };
  world.whatMoves = [town](std::uint64_t day_seed) { return makeTraffic(*town, day_seed); };
  return world;
}

/// An office that somebody walks through.
World walkedOffice(const SimulationOptions& options, std::uint64_t seed) {
  const auto office = std::make_shared<Office>(makeOffice(seeded(options.office, options, seed)));
  World world(options, officeLabels(),
              withChanges(std::move(office->mesh), officeLabels(), options.sim.changed, seed,
                          [](const Eigen::Vector3d&, Random&) { return std::nullopt; }));
  world.bodyPoses = [&options, office, seed](const SessionKind& kind, std::uint64_t session_seed) {
    Mount mount = kind.mount;
    mount.height_m = kHandHeight;
    mount.sway_rad = 0.01;
    // Lanes are narrower than those of cars.
    return carriedPoses(
        planWalk(*office, options.route_length_m, options.frame_spacing_m, kind.is_way_back, seed),
        mount, 0.15 * (kind.left_m + kLane), session_seed);
  };
  world.whatMoves = [office](std::uint64_t day_seed) { return makeClutter(*office, day_seed); };
  return world;
}

World makeWorld(const SimulationOptions& options, std::uint64_t seed) {
  return isOffice(options) ? walkedOffice(options, seed) : drivenTown(options, seed);
}

/// Options with what belongs to their style.
SimulationOptions styled(SimulationOptions o) {
  TownOptions& town = o.town;
  if (o.sim.style == "grid") {
    town.irregularity = 0;
    town.relief_m = 0.5;
    town.row_share = 0.6;
    o.sim.alike = std::max(o.sim.alike, 0.4);
  } else if (o.sim.style == "village") {
    town.blocks_x = town.blocks_y = 2;
    town.street_spacing_m = 130;
    town.irregularity = 0.8;
    town.relief_m = 4;
    town.house_density = 0.5;
    town.row_share = 0;
    town.tree_density = 1.5;
    town.winding_m = 8;
  } else if (o.sim.style == "campus") {
    town.blocks_x = town.blocks_y = 3;
    town.street_spacing_m = 115;
    town.irregularity = 0.3;
    town.house_density = 0.75;
    town.row_share = 0;
    town.car_density = 0.4;
    town.lots = Lots::halls;
  } else if (isOffice(o)) {
    o.sessions.aerial = o.sessions.winter = false;
    const SimulationOptions usual;
    if (o.route_length_m == usual.route_length_m) o.route_length_m = 60;
    if (o.frame_spacing_m == usual.frame_spacing_m) o.frame_spacing_m = 0.4;
    if (o.view_deg == usual.view_deg) o.view_deg = 60;
    // A projected pattern: 1 mm at 1 m, 3 cm at 4 m.
    o.depth_noise.baseline_m = 0.075;
    o.depth_noise.disparity_sigma_px = 0.035;
    o.depth_noise.bleeding_px = 0.8;
    o.depth_noise.max_range_m = kFarthest_m;
    o.label_noise.patch_m = 1;
  }
  return o;
}

}  // namespace

SimulatedRecording::SimulatedRecording(SessionPlan plan, Renderer renderer,
                                       const SimulationOptions& options)
    : plan_(std::move(plan)), renderer_(std::move(renderer)), options_(options) {}

Frame SimulatedRecording::withNoise(Frame frame, std::size_t index) const {
  if (plan_.sensor == Sensor::camera) {
    frame = withLabelNoise(std::move(frame), options_.label_noise, plan_.seed);
    return options_.isNoisy() ? withDepthNoise(std::move(frame), plan_.depth_noise, plan_.seed)
                              : frame;
  }
  if (!options_.isNoisy()) {
    const LidarNoise labels_only{0, 0, options_.lidar_noise.label_accuracy, 0};
    return withLidarNoise(std::move(frame), labels_only, plan_.seed);
  }
  if (size() > 1) {
    const std::size_t first = std::min(index, size() - 2);
    const Eigen::Isometry3d step =
        plan_.T_world_sensor[first].inverse() * plan_.T_world_sensor[first + 1];
    const double turns_per_step = options_.frame_spacing_m / (plan_.speed * kTurn_s);
    frame = withOwnMotion(std::move(frame), step,
                          options_.lidar_noise.uncorrected_motion / turns_per_step);
  }
  return withLidarNoise(std::move(frame), options_.lidar_noise, plan_.seed);
}

Frame SimulatedRecording::read(std::size_t index) const {
  const Eigen::Isometry3d& T_world_sensor = plan_.T_world_sensor.at(index);
  const bool is_lidar = plan_.sensor == Sensor::lidar;
  Frame frame = is_lidar ? renderer_.renderLidar(options_.lidar, T_world_sensor, options_.threads)
                         : renderer_.renderCamera(plan_.camera, T_world_sensor, options_.threads);
  frame.number = number(index);
  frame.stamp_s = stamp(index);
  frame.T_odom_sensor = pose(index);
  if (options_.quality != "clean") frame = withNoise(std::move(frame), index);
  for (float& depth : frame.depth.pixels)
    if (depth < plan_.nearest_m || depth > plan_.farthest_m) depth = 0;
  return frame;
}

std::vector<std::unique_ptr<SimulatedRecording>> makeSessions(const SimulationOptions& given,
                                                              std::vector<ObjectChange>* changes) {
  SimulationOptions options = styled(given);
  requireLegal(fieldsOf(options));
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const World world = makeWorld(options, seed);
  std::optional<const World> other_world;
  if (options.sessions.elsewhere) other_world.emplace(makeWorld(options, seed ^ kElsewhere));

  std::vector<std::unique_ptr<SimulatedRecording>> sessions;
  Eigen::Isometry3d T_map_world = Eigen::Isometry3d::Identity();
  for (const SessionKind& kind : sessionKinds(options)) {
    if (!kind.wanted) continue;
    const World& place = kind.is_elsewhere ? *other_world : world;
    SessionPlan plan = place.plan(kind);
    const double drift = options.isNoisy() && !kind.isMappingDrive() ? options.drift : 0;
    plan.T_odom_sensor = asOdometry(plan.T_world_sensor, drift, plan.seed);
    if (kind.number == SessionKind::kForward) {
      T_map_world = plan.T_odom_sensor.front() * plan.T_world_sensor.front().inverse();
    }
    for (const Eigen::Isometry3d& T : plan.T_world_sensor) {
      plan.T_map_sensor.push_back(T_map_world * T);
    }
    if (kind.number == SessionKind::kLidar) plan.T_odom_sensor = plan.T_map_sensor;
    if (kind.is_elsewhere) {
      const Eigen::Vector3d far_away(kFarAway, kFarAway, 0);
      for (Eigen::Isometry3d& T : plan.T_map_sensor) T.pretranslate(far_away);
    }
    sessions.push_back(place.record(kind, std::move(plan)));
  }
  if (changes) {
    *changes = world.changes;
    for (ObjectChange& change : *changes) {
      change.foot = T_map_world * change.foot;
      change.later = T_map_world * change.later;
    }
  }
  return sessions;
}

}  // namespace xview
