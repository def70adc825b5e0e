// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "object_town.h"
#include "xview/types/pose.h"
#include "xview/types/random.h"

namespace xview::bench {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep = 2;  // [m] between poses of a path

struct PathPose {
  double x, y, yaw;
};

/// A vertex seen from pose `pose` of the path.
struct Sighting {
  Vertex vertex;
  std::size_t pose;
};

bool isSurface(TownClass label) {
  return label == TownClass::street || label == TownClass::building || label == TownClass::fence ||
         label == TownClass::hedge;
}

TownClass confusedWith(TownClass label, Random& random) {
  static constexpr TownClass kPartner[] = {TownClass::building, TownClass::fence, TownClass::hedge,
                                           TownClass::sign,     TownClass::fence, TownClass::hedge,
                                           TownClass::pole,     TownClass::tree};
  if (random.uniform() < 0.6) return kPartner[static_cast<std::uint32_t>(label) - 1];
  return static_cast<TownClass>(1 + random.below(8));
}

/// What the sensor covers, along and across the path [m].
struct Footprint {
  double behind, ahead, lateral;
};

Footprint footprintOf(TownView view) {
  switch (view) {
    case TownView::forward:
      return {2, 25, 19};
    case TownView::rear:
      return {-25, -2, 19};
    case TownView::aerial:
      return {-20, 20, 28};
  }
  return {0, 0, 0};
}

/// One recording session.
class Observer {
 public:
  Observer(const ObjectTown& town, const TownNoise& noise, const TownSampling& sampling,
           TownView view, std::uint64_t session, Random& random)
      : town_(town),
        noise_(noise),
        sampling_(sampling),
        view_(view),
        session_(session),
        random_(random),
        last_path_of_object_(town.objects().size(), 0) {}

  /// Each object is looked at once per path, when it first comes into the footprint.
  std::vector<Sighting> drive(const std::vector<PathPose>& path) {
    ++path_;
    sightings_.clear();
    double next_street = random_.uniform(0, sampling_.surface_m);
    for (std::size_t k = 0; k < path.size(); ++k) {
      const double travelled = static_cast<double>(k) * kStep;
      for (; travelled >= next_street;
           next_street += sampling_.surface_m * (1 + 0.1 * random_.uniform())) {
        seeStreet(path[k], k);
      }
      if (random_.uniform() < noise_.spurious_per_100m * kStep / 100) seeSpurious(path[k], k);
      seeObjects(path[k], k);
    }
    return std::move(sightings_);
  }

 private:
  Eigen::Vector2d inTown(const PathPose& p, double along, double lateral) const {
    const double c = std::cos(p.yaw), s = std::sin(p.yaw);
    return {p.x + c * along - s * lateral, p.y + s * along + c * lateral};
  }

  void emit(TownClass label, const Eigen::Vector2d& p, double z, std::size_t pose) {
    Sighting sighting;
    sighting.vertex.label = static_cast<std::uint32_t>(label);
    sighting.vertex.position = {p.x(), p.y(), z};
    sighting.pose = pose;
    sightings_.push_back(sighting);
  }

  void seeStreet(const PathPose& p, std::size_t pose) {
    if (random_.uniform() < 0.4 * noise_.miss) return;
    const double along = view_ == TownView::forward ? 8 : view_ == TownView::rear ? -8 : 0;
    const Eigen::Vector2d at =
        inTown(p, along + noise_.sigma_m * random_.normal(), random_.normal());
    const TownClass label = random_.uniform() < 0.5 * noise_.label_error
                                ? confusedWith(TownClass::street, random_)
                                : TownClass::street;
    emit(label, at, town_.ground(at.x(), at.y()) + 0.1 * random_.normal(), pose);
  }

  void seeSpurious(const PathPose& p, std::size_t pose) {
    const Footprint f = footprintOf(view_);
    const Eigen::Vector2d at =
        inTown(p, random_.uniform(f.behind, f.ahead), random_.uniform(-f.lateral, f.lateral));
    emit(static_cast<TownClass>(1 + random_.below(8)), at,
         town_.ground(at.x(), at.y()) + random_.uniform(0, 4), pose);
  }

  void seeObjects(const PathPose& p, std::size_t pose) {
    const Footprint f = footprintOf(view_);
    const Eigen::Vector2d centre = inTown(p, 0.5 * (f.behind + f.ahead), 0);
    town_.objectsNear(centre.x(), centre.y(), std::hypot(0.5 * (f.ahead - f.behind), f.lateral),
                      near_);
    const double c = std::cos(p.yaw), s = std::sin(p.yaw);
    for (const std::uint32_t id : near_) {
      if (last_path_of_object_[id] == path_) continue;
      const TownObject& object = town_.objects()[id];
      const double dx = object.x - p.x, dy = object.y - p.y;
      const double along = c * dx + s * dy, lateral = -s * dx + c * dy;
      if (along < f.behind || along > f.ahead || std::abs(lateral) > f.lateral) continue;
      last_path_of_object_[id] = path_;
      if (canSee(object) && isThere(id, object)) seeObject(id, object, pose);
    }
  }

  bool canSee(const TownObject& object) {
    if (view_ == TownView::aerial)
      return object.label != TownClass::pole && object.label != TownClass::sign;
    if (object.place == TownObject::Place::back_yard) return false;
    // Some things show only one face, most signs do.
    if (view_ == TownView::forward && object.face < 0.07) return false;
    if (view_ == TownView::rear && object.face >= 0.07 && object.face < 0.14) return false;
    const bool turned_away =
        object.label == TownClass::sign && (object.face > 0.5) == (view_ == TownView::rear);
    return !(turned_away && random_.uniform() < 0.5);
  }

  bool isRedrawn(std::uint32_t id) const {
    return Random(session_ * 77 + 3, id).uniform() < noise_.car_change;
  }

  bool isThere(std::uint32_t id, const TownObject& object) const {
    if (object.place != TownObject::Place::parking_bay) return true;
    Random random = isRedrawn(id) ? Random(session_ * 77 + 4, id) : Random(town_.seed() + 11, id);
    return random.uniform() < object.occupancy;
  }

  void seeObject(std::uint32_t id, const TownObject& object, std::size_t pose) {
    if (!isSurface(object.label) ||
        (view_ == TownView::aerial && object.label == TownClass::building)) {
      seePoint(id, object, 0, pose);
      return;
    }
    const double length = 2 * object.half_length;
    for (double t = random_.uniform(0, std::min(length, sampling_.surface_m)); t < length;
         t += sampling_.surface_m * 1.02) {
      seePoint(id, object, t - object.half_length, pose);
    }
  }

  void seePoint(std::uint32_t id, const TownObject& object, double along, std::size_t pose) {
    double sigma = noise_.sigma_m, miss = noise_.miss, z = object.z + 0.5 * object.height;
    if (object.label == TownClass::building) sigma = std::max(0.5, sigma);
    Eigen::Vector2d p(object.x + object.direction.x() * along,
                      object.y + object.direction.y() * along);
    if (object.place == TownObject::Place::parking_bay && isRedrawn(id)) {
      p.x() += 1.6 * (Random(session_ * 77 + 5, id).uniform() - 0.5);
    }
    if (view_ == TownView::aerial) {
      if (object.label == TownClass::building) {
        p += 5 * object.outward.cast<double>();
        z = object.z + object.height;
      }
      if (object.label == TownClass::tree) {
        z = object.z + 0.8 * object.height;
        sigma = std::max(0.5, sigma);
        miss *= 0.7;
      }
      if (object.label == TownClass::fence) miss = 1 - 0.5 * (1 - miss);
    }
    p += sigma * Eigen::Vector2d(random_.normal(), random_.normal());
    z += 0.5 * sigma * random_.normal();
    const TownClass label =
        random_.uniform() < noise_.label_error ? confusedWith(object.label, random_) : object.label;
    if (random_.uniform() >= miss) emit(label, p, z, pose);
  }

  const ObjectTown& town_;
  const TownNoise& noise_;
  const TownSampling& sampling_;
  TownView view_;
  std::uint64_t session_;
  Random& random_;
  std::uint32_t path_ = 0;
  std::vector<std::uint32_t> last_path_of_object_;
  std::vector<std::uint32_t> near_;
  std::vector<Sighting> sightings_;
};

/// Keeps the first of several vertices of a class that are close together.
class Merger {
 public:
  explicit Merger(const TownSampling& sampling) : sampling_(sampling) {}

  void add(const Vertex& vertex) {
    const bool surface = isSurface(static_cast<TownClass>(vertex.label));
    const double distance = surface ? sampling_.surface_m : sampling_.object_m;
    const auto cx = static_cast<std::int64_t>(std::floor(vertex.position.x() / distance));
    const auto cy = static_cast<std::int64_t>(std::floor(vertex.position.y() / distance));
    for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
      for (std::int64_t x = cx - 1; x <= cx + 1; ++x) {
        const auto it = cells_.find(key(x, y, vertex.label));
        if (it == cells_.end()) continue;
        for (const std::uint32_t k : it->second) {
          if ((graph_.vertices[k].position - vertex.position).head<2>().norm() < distance) return;
        }
      }
    }
    cells_[key(cx, cy, vertex.label)].push_back(static_cast<std::uint32_t>(graph_.size()));
    graph_.vertices.push_back(vertex);
  }

  SemanticGraph graph() && {
    graph_.neighbours.resize(graph_.size());
    return std::move(graph_);
  }

 private:
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::uint32_t label) {
    return (static_cast<std::uint64_t>(x + (1 << 20)) << 34) ^
           (static_cast<std::uint64_t>(y + (1 << 20)) << 8) ^ label;
  }

  TownSampling sampling_;
  SemanticGraph graph_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// A drive of the wanted length over random streets, never turning back if it can be avoided.
std::vector<PathPose> randomPath(const ObjectTown& town, double length_m, Random& random) {
  auto street = random.below(static_cast<std::uint32_t>(town.streets().size()));
  std::uint32_t from = town.streets()[street].from, to = town.streets()[street].to;
  if (random.uniform() < 0.5) std::swap(from, to);
  double s = random.uniform(0, 0.7 * (town.crossings()[to] - town.crossings()[from]).norm());
  const double lane = random.uniform(-1, 1);
  const auto count = static_cast<std::size_t>(std::max(0.0, length_m) / kStep + 1e-9) + 1;
  std::vector<PathPose> path;
  while (path.size() < count) {
    const Eigen::Vector2d a = town.crossings()[from], b = town.crossings()[to];
    const double street_length = (b - a).norm();
    const Eigen::Vector2d along = (b - a) / street_length, left(-along.y(), along.x());
    for (; s < street_length && path.size() < count; s += kStep) {
      const Eigen::Vector2d p = a + along * s + left * lane;
      path.push_back({p.x(), p.y(), std::atan2(along.y(), along.x())});
    }
    s -= street_length;
    std::vector<std::uint32_t> choices;
    for (const std::uint32_t next : town.streetsAt(to)) {
      if (next != street) choices.push_back(next);
    }
    if (!choices.empty())
      street = choices[random.below(static_cast<std::uint32_t>(choices.size()))];
    from = to;
    to = town.streets()[street].from == from ? town.streets()[street].to
                                             : town.streets()[street].from;
  }
  return path;
}

/// The path as odometry tells it: own origin and heading, wrong length scale, drifting heading.
std::vector<PathPose> odometryOf(const std::vector<PathPose>& path, double drift, Random& random) {
  const double scale = 1 + drift * random.normal(), yaw_per_metre = drift * random.normal() / 20;
  const double turn = random.uniform(-kPi, kPi);
  double error = 0;
  std::vector<PathPose> odometry{{0, 0, path[0].yaw + turn}};
  for (std::size_t k = 1; k < path.size(); ++k) {
    const double dx = path[k].x - path[k - 1].x, dy = path[k].y - path[k - 1].y;
    error += yaw_per_metre * std::hypot(dx, dy) + 0.02 * drift * random.normal();
    const double c = std::cos(turn + error), s = std::sin(turn + error);
    odometry.push_back({odometry[k - 1].x + scale * (c * dx - s * dy),
                        odometry[k - 1].y + scale * (s * dx + c * dy), path[k].yaw + turn + error});
  }
  return odometry;
}

}  // namespace

SemanticGraph mapObjectTown(const ObjectTown& town, const TownNoise& noise,
                            const TownSampling& sampling, std::uint64_t session) {
  Random random(town.seed() + 1, session);
  Observer observer(town, noise, sampling, TownView::forward, session, random);
  Merger merger(sampling);
  for (const ObjectTown::Street& street : town.streets()) {
    const Eigen::Vector2d a = town.crossings()[street.from], b = town.crossings()[street.to];
    const double length = (b - a).norm();
    const Eigen::Vector2d along = (b - a) / length;
    std::vector<PathPose> path;
    for (double s = -10; s < length - 2; s += kStep) {
      const Eigen::Vector2d p = a + along * s;
      path.push_back({p.x(), p.y(), std::atan2(along.y(), along.x())});
    }
    for (const Sighting& sighting : observer.drive(path)) merger.add(sighting.vertex);
  }
  return std::move(merger).graph();
}

TownQuery queryObjectTown(const ObjectTown& town, const TownNoise& noise,
                          const TownSampling& sampling, TownView view, double length_m,
                          std::uint64_t seed) {
  Random random(town.seed() + 2, seed);
  std::vector<PathPose> path = randomPath(town, length_m, random);
  if (view == TownView::aerial) {
    const double offset = random.uniform(-4, 4);
    for (PathPose& p : path) {
      p.x -= std::sin(p.yaw) * offset;
      p.y += std::cos(p.yaw) * offset;
    }
  }
  Observer observer(town, noise, sampling, view, 1000 + seed, random);
  const std::vector<Sighting> sightings = observer.drive(path);
  const std::vector<PathPose> odometry = odometryOf(path, noise.drift, random);
  const double z0 = town.ground(path[0].x, path[0].y);
  const Eigen::Vector2d tilt(random.normal() * kPi / 180, random.normal() * kPi / 180);

  Merger merger(sampling);
  for (const Sighting& sighting : sightings) {
    const PathPose &truth = path[sighting.pose], &odom = odometry[sighting.pose];
    const double turn = odom.yaw - truth.yaw, c = std::cos(turn), s = std::sin(turn);
    Vertex vertex = sighting.vertex;
    const double dx = vertex.position.x() - truth.x, dy = vertex.position.y() - truth.y;
    vertex.position.head<2>() << odom.x + c * dx - s * dy, odom.y + s * dx + c * dy;
    vertex.position.z() += -z0 + tilt.dot(vertex.position.head<2>());
    merger.add(vertex);
  }

  TownQuery query;
  query.graph = std::move(merger).graph();
  const Eigen::Vector2d end(odometry.back().x, odometry.back().y);
  query.last_in_query << end, town.ground(path.back().x, path.back().y) - z0 + tilt.dot(end);
  query.last_in_map << path.back().x, path.back().y, town.ground(path.back().x, path.back().y);
  const PathPose &truth = path[path.size() / 2], &odom = odometry[path.size() / 2];
  const double yaw = truth.yaw - odom.yaw, c = std::cos(yaw), s = std::sin(yaw);
  query.T_map_query = poseFromYaw(
      {truth.x - (c * odom.x - s * odom.y), truth.y - (s * odom.x + c * odom.y), z0}, yaw);
  return query;
}

}  // namespace xview::bench
