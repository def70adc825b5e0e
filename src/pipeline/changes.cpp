// SPDX-License-Identifier: BSD-3-Clause
#include "xview/changes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "xview/types/cells.h"
#include "xview/types/median.h"

namespace xview {
namespace {

// Lengths of a town (types/semantic_place.h).
constexpr double kBlock_m = 1;          ///< of the index of points; no reach is longer
constexpr double kAboveGround_m = 0.3;  ///< lower points may be ground
constexpr double kPostRadius_m = 0.45;  ///< points of a post are as near to its axis
constexpr double kPostHeight_m = 12;    ///< and not higher
constexpr double kAround_m = 1;         ///< ground within that of a foot was looked at
constexpr double kMeet_m = 0.4;         ///< points of two visits on one thing are as near
constexpr double kSameObject_m = 0.5;   ///< and their vertices
constexpr double kMoved_m = 8;          ///< farther away it is another thing
constexpr double kBeside_m = 2.5;       ///< for what is met by chance

constexpr double kLookedShare = 0.6;  ///< of the cells around a foot
constexpr double kUsualLooks = 0.9;   ///< of the things of a kind are seen from as near as that

/// Prior probability that a landmark changes between two visits.
constexpr double kChanged = 0.05;
/// Prior share of unchanged landmarks that are not matched at all, and its weight in landmarks of
/// the two visits.
constexpr double kUnmet = 0.01, kUnmetWeight = 25;

bool isPost(Kind kind) { return isPoleLike(kind) || kind == Kind::trunk; }

/// Where the points of a thing are; frame of its visit.
Eigen::AlignedBox3d boxOf(const Vertex& v, bool is_post) {
  if (is_post) {
    const Eigen::Vector3d side(kPostRadius_m, kPostRadius_m, 0);
    return Eigen::AlignedBox3d(v.position - side, v.position + side)
        .extend(v.position + Eigen::Vector3d(0, 0, kPostHeight_m));
  }
  const Eigen::Vector3d half = v.extent / 2 + Eigen::Vector3d::Constant(kMeet_m / 2);
  return {v.position - half, v.position + half};
}

/// A vertex that may change, as the other visit sees it.
struct Object {
  const Vertex* vertex = nullptr;
  bool is_dynamic = false;
  Eigen::Vector3d position;  ///< common frame
  bool was_looked_at = false, is_matched = false;
  double met = 0;                  ///< share of its points that the other visit meets
  std::array<double, 4> chance{};  ///< the same, beside it
  double changed = 0;              ///< probability that one visit has it and the other one not

  bool isChanged() const { return changed >= 0.5; }
};

/// What one visit has seen. Points of a common frame are asked for.
class Visit {
 public:
  Visit(const Place& place, const Eigen::Isometry3d& T_common_visit, double meet_m)
      : place_(place),
        T_common_visit_(T_common_visit),
        T_(T_common_visit.inverse()),
        meet_m_(meet_m) {
    for (std::size_t i = 0; i < place.cloud.size(); ++i) {
      const std::uint32_t label = place.cloud.points[i].label;
      const Eigen::Vector3d p = place.cloud.position(i);
      if (isGround(place.labels.kind(label)) || place.labels.role(label) == Role::ignored) continue;
      const GroundCell* cell = cellAt(inCells(p));
      if (cell && (place.bev.alignment * p).z() < place.bev.origin_z + cell->z + kAboveGround_m)
        continue;
      upright_.add(cellOf(p, kBlock_m, 0), i);
    }
    collectObjects();
    measureLooks();
  }

  bool tellsWhereItLooked() const { return !place_.bev.known.empty() && !place_.cloud.empty(); }
  std::vector<Object>& objects() { return objects_; }
  const std::vector<Object>& objects() const { return objects_; }
  const LabelSet& labels() const { return place_.labels; }

  /// Of all vertices, when the things are judged.
  std::vector<Presence> presence() const {
    std::vector<Presence> of_vertex(place_.graph.size(), Presence::unknown);
    for (const Object& object : objects_) {
      if (!object.was_looked_at) continue;
      of_vertex[static_cast<std::size_t>(object.vertex - place_.graph.vertices.data())] =
          object.isChanged() ? Presence::gone : Presence::stands;
    }
    return of_vertex;
  }

  /// The points of a thing, which stand above the ground; common frame.
  std::vector<Eigen::Vector3d> pointsOf(const Object& object) const {
    const Vertex& v = *object.vertex;
    const bool is_post = isPost(labels().kind(v.label));
    const Eigen::AlignedBox3d box = boxOf(v, is_post);
    std::vector<Eigen::Vector3d> of_class, of_any;
    const ClassCell low = cellOf(box.min(), kBlock_m, 0), high = cellOf(box.max(), kBlock_m, 0);
    const auto take = [&](std::size_t i) {
      const Eigen::Vector3d p = place_.cloud.position(i);
      if (!box.contains(p)) return;
      const bool same = place_.cloud.points[i].label == v.label;
      (same ? of_class : of_any).push_back(T_common_visit_ * p);
    };
    for (auto z = low.z; z <= high.z; z += 3) {  // each call is about three cells a side
      for (auto y = low.y; y <= high.y; y += 3) {
        for (auto x = low.x; x <= high.x; x += 3)
          upright_.forAround({x + 1, y + 1, z + 1, 0}, take);
      }
    }
    // In noise a post may have points of other labels only.
    return of_class.empty() && is_post ? of_any : of_class;
  }

  /// Fills in what this visit says of a thing of the other one.
  void judge(Object& object, const std::vector<Eigen::Vector3d>& points) const {
    const Vertex& v = *object.vertex;
    object.was_looked_at = !points.empty() && hasLookedAt(object.position, v.label);
    if (!object.was_looked_at) return;
    object.met = shareMet(points, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < object.chance.size(); ++i) {
      const double angle = M_PI * (0.25 + 0.5 * static_cast<double>(i));
      object.chance[i] =
          shareMet(points, kBeside_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    }
    // The middle of a large thing depends on what of it was seen, the foot of a post does not.
    const bool is_post = isPost(labels().kind(v.label));
    const double large_m = is_post ? 0 : v.extent.head<2>().maxCoeff() / 4;
    const double reach_m = kSameObject_m + meet_m_ - kMeet_m + large_m;
    object.is_matched = std::any_of(objects_.begin(), objects_.end(), [&](const Object& other) {
      return labels().kind(other.vertex->label) == labels().kind(v.label) &&
             (other.position - object.position).norm() <= reach_m;
    });
  }

 private:
  void collectObjects() {
    for (const Vertex& v : place_.graph.vertices) {
      const Role role = labels().role(v.label);
      if (role != Role::object && role != Role::dynamic) continue;
      Object object;
      object.vertex = &v;
      object.is_dynamic = role == Role::dynamic;
      object.position = T_common_visit_ * v.position;
      objects_.push_back(object);
    }
  }

  /// From how far away things of each kind are seen.
  void measureLooks() {
    std::map<Kind, std::vector<double>> distances;
    for (const Object& object : objects_)
      distances[labels().kind(object.vertex->label)].push_back(nearestPose(object.position));
    for (auto& [kind, values] : distances) looks_m_[kind] = quantileOf(values, kUsualLooks);
  }

  double nearestPose(const Eigen::Vector3d& p_common) const {
    const Eigen::Vector3d p = T_ * p_common;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Isometry3d& pose : place_.poses)
      nearest = std::min(nearest, (pose.translation() - p).norm());
    return nearest;
  }

  /// A thing that stands at a place would have been seen.
  bool hasLookedAt(const Eigen::Vector3d& p_common, std::uint32_t label) const {
    const auto usual = looks_m_.find(labels().kind(label));
    if (usual != looks_m_.end() && nearestPose(p_common) > usual->second) return false;
    const Eigen::Vector2d foot = inCells(T_ * p_common);
    const double reach = kAround_m / place_.bev.cell_m;
    int all = 0, measured = 0;
    for (double y = std::floor(foot.y() - reach); y <= foot.y() + reach; ++y) {
      for (double x = std::floor(foot.x() - reach); x <= foot.x() + reach; ++x) {
        const Eigen::Vector2d middle(x + 0.5, y + 0.5);
        if ((middle - foot).norm() > reach) continue;
        const GroundCell* cell = cellAt(middle);
        measured += cell && cell->measured;
        ++all;
      }
    }
    return measured >= kLookedShare * all;
  }

  double shareMet(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& shift) const {
    const auto met = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& q) {
      const Eigen::Vector3d p = T_ * (q + shift);
      return upright_.anyAround(cellOf(p, kBlock_m, 0), [&](std::size_t i) {
        return (place_.cloud.position(i) - p).norm() <= meet_m_;
      });
    });
    return static_cast<double>(met) / static_cast<double>(points.size());
  }

  /// A point of this visit in cells of its BEV grid.
  Eigen::Vector2d inCells(const Eigen::Vector3d& p) const {
    const BevGrid& bev = place_.bev;
    const Eigen::Vector3d at = bev.alignment * p;
    return Eigen::Vector2d(at.x() - bev.origin_x, at.y() - bev.origin_y) / bev.cell_m;
  }

  const GroundCell* cellAt(const Eigen::Vector2d& in_cells) const {
    return place_.bev.knownCell(floorToInt(in_cells.x()), floorToInt(in_cells.y()));
  }

  const Place& place_;
  Eigen::Isometry3d T_common_visit_, T_;
  double meet_m_;
  CellLists upright_;  ///< points above the ground, this visit's frame
  std::vector<Object> objects_;
  std::map<Kind, double> looks_m_;
};

/// How much is met of things that stand, and how much where they do not.
class Experience {
 public:
  void add(const std::vector<Object>& objects) {
    for (const Object& object : objects) {
      if (!object.was_looked_at) continue;
      if (object.is_matched) standing_.push_back(object.met);
      chance_.insert(chance_.end(), object.chance.begin(), object.chance.end());
    }
  }

  /// Probability that a landmark is gone, given the share of its points that is matched.
  double probabilityOfChange(double met) const {
    const auto so_little = [&](double m) { return m <= met; };
    const auto so_much = [&](double m) { return m >= met; };
    const double standing = shareOf(standing_, so_little, kUnmet);
    const double changed = shareOf(chance_, so_much, 1);
    return kChanged * changed / (kChanged * changed + (1 - kChanged) * standing);
  }

 private:
  template <class Condition>
  static double shareOf(const std::vector<double>& values, const Condition& condition,
                        double expected) {
    const auto count = std::count_if(values.begin(), values.end(), condition);
    return (static_cast<double>(count) + expected * kUnmetWeight) /
           (static_cast<double>(values.size()) + kUnmetWeight);
  }
  std::vector<double> standing_, chance_;
};

std::vector<Change> changesAmong(const std::vector<Object>& objects, Change::What what,
                                 double sigma_m) {
  std::vector<Change> changes;
  for (const Object& object : objects) {
    if (!object.isChanged()) continue;
    Change change;
    change.what = what;
    change.label = object.vertex->label;
    change.is_dynamic = object.is_dynamic;
    change.position = object.position;
    change.extent = object.vertex->extent;
    change.sigma_m = std::hypot(object.vertex->sigma_m, sigma_m);
    change.probability = object.changed;
    changes.push_back(change);
  }
  return changes;
}

/// Joins what is gone with what is new, the nearest pair of one class first.
void joinMoved(std::vector<Change>& gone, std::vector<Change>& added) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    for (std::size_t j = 0; j < added.size(); ++j) {
      const double way_m = (gone[i].position - added[j].position).norm();
      const bool may_be = gone[i].label == added[j].label && !gone[i].is_dynamic;
      if (may_be && way_m <= kMoved_m) pairs.emplace_back(way_m, i, j);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> is_taken(added.size(), false);
  for (const auto& [way_m, i, j] : pairs) {
    if (gone[i].moved_to || is_taken[j]) continue;
    is_taken[j] = true;
    gone[i].what = Change::What::moved;
    gone[i].moved_to = added[j].position;
    gone[i].probability *= added[j].probability;
    gone[i].sigma_m = std::hypot(gone[i].sigma_m, added[j].sigma_m);
  }
  std::size_t kept = 0;
  for (std::size_t j = 0; j < added.size(); ++j) {
    if (!is_taken[j]) added[kept++] = added[j];
  }
  added.resize(kept);
}

Changes compare(Visit& earlier, Visit& later, double sigma_m) {
  Changes result;
  result.has_looked = earlier.tellsWhereItLooked() && later.tellsWhereItLooked();
  for (Object& object : earlier.objects()) later.judge(object, earlier.pointsOf(object));
  for (Object& object : later.objects()) earlier.judge(object, later.pointsOf(object));
  Experience experience;
  experience.add(earlier.objects());
  experience.add(later.objects());
  for (Visit* visit : {&earlier, &later}) {
    for (Object& object : visit->objects()) {
      if (object.was_looked_at && !object.is_matched)
        object.changed = experience.probabilityOfChange(object.met);
    }
  }
  result.presence = earlier.presence();
  auto gone = changesAmong(earlier.objects(), Change::What::gone, sigma_m);
  auto added = changesAmong(later.objects(), Change::What::added, sigma_m);
  joinMoved(gone, added);
  for (const Object& object : earlier.objects())
    result.compared += object.was_looked_at && !object.is_dynamic;
  result.compared += static_cast<std::size_t>(std::count_if(
      added.begin(), added.end(), [](const Change& change) { return !change.is_dynamic; }));
  result.changes = std::move(gone);
  result.changes.insert(result.changes.end(), added.begin(), added.end());
  std::stable_sort(result.changes.begin(), result.changes.end(),
                   [](const Change& a, const Change& b) {
                     return std::make_tuple(a.is_dynamic, a.what, -a.probability) <
                            std::make_tuple(b.is_dynamic, b.what, -b.probability);
                   });
  return result;
}

bool isUpright(const LabelSet& labels, std::uint32_t label) {
  return !isGround(labels.kind(label)) && labels.role(label) != Role::ignored;
}

/// Takes points of a class out of a box: of a post those of any class, if none is of its own.
void removePoints(const LabelSet& labels, const Vertex& v, LabelledCloud& cloud) {
  const bool is_post = isPost(labels.kind(v.label));
  const Eigen::AlignedBox3d box = boxOf(v, is_post);
  const auto isIn = [&](const Point& p, bool any_class) {
    return (any_class ? isUpright(labels, p.label) : p.label == v.label) &&
           box.contains(cloud.origin + p.getVector3fMap().cast<double>());
  };
  const auto isOfClass = [&](const Point& p) { return isIn(p, false); };
  const bool any_class =
      is_post && std::none_of(cloud.points.begin(), cloud.points.end(), isOfClass);
  cloud.points.erase(std::remove_if(cloud.points.begin(), cloud.points.end(),
                                    [&](const Point& p) { return isIn(p, any_class); }),
                     cloud.points.end());
}

/// Takes samples out of the BEV grid where things stood, unless something else stands there.
void removeSamples(const Place& place, const std::vector<Vertex>& removed, BevGrid& bev) {
  const auto inBev = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    return (bev.alignment * p).head<2>() - Eigen::Vector2d(bev.origin_x, bev.origin_y);
  };
  CellIndex upright;
  for (std::size_t i = 0; i < place.cloud.size(); ++i) {
    if (!isUpright(place.labels, place.cloud.points[i].label)) continue;
    const Eigen::Vector2d at = inBev(place.cloud.position(i)) / bev.cell_m;
    upright.findOrAdd(floorToInt(at.x()), floorToInt(at.y()));
  }
  const auto stands = [&](const BevSample& s) {
    return upright.find(floorToInt(s.x / bev.cell_m), floorToInt(s.y / bev.cell_m)) >= 0;
  };
  for (const Vertex& v : removed) {
    const Eigen::Vector2d middle = inBev(v.position);
    const double half_m = boxOf(v, isPost(place.labels.kind(v.label))).sizes().head<2>().norm() / 2;
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      const auto channel = static_cast<BevChannel>(c);
      if (isArea(channel)) continue;
      const auto isGone = [&](const BevSample& s) {
        const double away_m = (Eigen::Vector2d(s.x, s.y) - middle).norm();
        return isObject(channel) ? away_m <= kSameObject_m : away_m <= half_m && !stands(s);
      };
      auto& samples = bev.samples[c];
      samples.erase(std::remove_if(samples.begin(), samples.end(), isGone), samples.end());
    }
  }
}

void removeVertices(const std::vector<bool>& is_removed, SemanticGraph& graph) {
  std::vector<std::uint32_t> now_at(graph.size());
  std::vector<Vertex> kept;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    now_at[i] = static_cast<std::uint32_t>(kept.size());
    if (!is_removed[i]) kept.push_back(graph.vertices[i]);
  }
  BlobEdges edges;
  for (const auto& [a, b] : graph.edges()) {
    if (!is_removed[a] && !is_removed[b]) edges.emplace_back(now_at[a], now_at[b]);
  }
  graph.vertices = std::move(kept);
  if (graph.edge_radius_m > 0)
    graph.neighbours.clear();  // the radius tells
  else
    graph.setEdges(edges);
}

}  // namespace

const char* toString(Change::What what) {
  static constexpr const char* kNames[] = {"gone", "new", "moved"};
  return kNames[static_cast<int>(what)];
}

Changes findChanges(const Place& earlier, const Place& later,
                    const Eigen::Isometry3d& T_earlier_later, double sigma_m) {
  const double size = earlier.size;
  const Scaled<Place> earlier_town(earlier, 1 / size), later_town(later, 1 / size);
  Eigen::Isometry3d T = T_earlier_later;
  scaleLengths(1 / size, T);
  const double town_sigma_m = sigma_m / size;
  const double meet_m = std::min(kBlock_m, kMeet_m + 2 * town_sigma_m);
  Visit first(*earlier_town, Eigen::Isometry3d::Identity(), meet_m);
  Visit second(*later_town, T, meet_m);
  Changes result = compare(first, second, town_sigma_m);
  for (Change& change : result.changes) {
    change.position *= size;
    change.extent *= size;
    change.sigma_m *= size;
    if (change.moved_to) *change.moved_to *= size;
  }
  return result;
}

void removeObjects(Place& place, const std::vector<std::size_t>& vertices) {
  const double size = place.size;
  scaleLengths(1 / size, place);
  std::vector<Vertex> removed;
  std::vector<bool> is_removed(place.graph.size());
  for (const std::size_t i : vertices) {
    is_removed[i] = true;
    removed.push_back(place.graph.vertices[i]);
    removePoints(place.labels, removed.back(), place.cloud);
  }
  removeSamples(place, removed, place.bev);
  removeVertices(is_removed, place.graph);
  scaleLengths(size, place);
}

}  // namespace xview
