// SPDX-License-Identifier: BSD-3-Clause
#include "compare/changes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <tuple>

#include "base/cells.h"
#include "base/median.h"
#include "landmark_box.h"
#include "localizer/query_check.h"
#include "place/blobs.h"
#include "place/sound_input.h"
#include "sight.h"
#include "verdict/verdict.h"
#include "xview/base/error.h"

namespace xview {
namespace {

// Lengths of a town (base/semantic_place.h).
constexpr double kBlock_m = 1;          ///< of the index of points; no reach is longer
constexpr double kAboveGround_m = 0.3;  ///< lower points may be ground
constexpr double kAround_m = 1;         ///< ground within that of a foot was looked at
constexpr double kMoved_m = 8;          ///< farther away it is another thing
constexpr double kBeside_m = 2.5;       ///< for what is met by chance
constexpr double kNear_m = 4;           ///< who saw one of two vertices could see the other
constexpr double kSight_m = 30;         ///< things are seen from as far
constexpr float kJoined_m = 0.7f;       ///< points of a thing without a class are as near
constexpr double kThing_m = 8;          ///< what is longer is a wall or a hedge

constexpr double kGroundShare = 0.6;      ///< of the cells around a foot
constexpr double kSeenShare = 0.5;        ///< of the points of a thing that are not out of view
constexpr double kObservedShare = 0.2;    ///< of all its points
constexpr double kAroundShare = 0.6;      ///< of the points around it are met
constexpr double kSeenOftenShare = 0.3;   ///< of the frames that see it; fewer is noise
constexpr double kStandsShare = 0.5;      ///< of its points; it stands if more of them are met
constexpr double kOtherShare = 0.1;       ///< of the met points is of its class by chance
constexpr std::size_t kAsked = 60;        ///< points of a thing
constexpr std::uint32_t kFewPoints = 20;  ///< say little of how pure labels are
constexpr int kFewestOfThing = 10;        ///< points of a thing without a class

/// Prior probability that a landmark changes between two visits.
constexpr double kChanged = 0.05;
/// Prior probability that another landmark took its place.
constexpr double kReplaced = 0.1;
/// Prior share of unchanged landmarks that are not matched at all, and its weight in landmarks of
/// the two visits.
constexpr double kUnmet = 0.01, kUnmetWeight = 25;

/// Where a visit may have seen things.
Eigen::AlignedBox3d seenBy(const Place& place, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < place.cloud.size(); ++i) box.extend(T * place.cloud.position(i));
  const Eigen::Vector3d rim = Eigen::Vector3d::Constant(kSight_m);
  return box.isEmpty() ? box : Eigen::AlignedBox3d(box.min() - rim, box.max() + rim);
}

/// What a visit says of the points of a landmark of the other visit.
struct Evidence {
  double asked = 0;
  double same = 0, other = 0;  ///< met, with a point of its class or without
  double free = 0;             ///< where rays pass
  double hidden = 0;           ///< neither; the rest is out of view

  double met() const { return same + other; }
  double observed() const { return met() + free; }
  double metShare() const { return observed() > 0 ? met() / observed() : 0; }
  bool suffices() const {
    return observed() > 0 && observed() >= kSeenShare * (observed() + hidden) &&
           observed() >= kObservedShare * asked;
  }
  bool isOfAnotherClass() const {
    return metShare() >= kStandsShare && same <= kOtherShare * met();
  }
};

/// One class, or two of a kind that tells the shape: poles are poles whatever they carry.
bool isSameThing(const LabelSet& labels, std::uint32_t a, std::uint32_t b) {
  const Kind kind = labels.kind(a);
  return a == b || (tellsShape(kind) && kind == labels.kind(b));
}

/// A vertex that may change, as the other visit sees it.
struct Object {
  const Vertex* vertex = nullptr;
  bool is_post = false, is_dynamic = false;
  Eigen::AlignedBox3d box;              ///< its visit's frame
  Eigen::Vector3d position;             ///< common frame
  std::vector<Eigen::Vector3d> points;  ///< common frame, above the ground
  bool was_looked_at = false, is_matched = false;
  Evidence evidence;
  std::array<double, 4> chance{};  ///< share of its points that are met beside it
  double changed = 0;              ///< probability that one visit has it and the other one not

  bool isChanged() const { return changed >= 0.5; }
};

/// What one visit has seen. Callers ask for points of the common frame.
class Visit {
 public:
  Visit(const Place& place, const Eigen::Isometry3d& T_common_visit, double meet_m,
        const Eigen::AlignedBox3d& region)
      : place_(place),
        T_common_visit_(T_common_visit),
        T_(T_common_visit.inverse()),
        meet_m_(meet_m),
        region_(region),
        sight_(place, region_) {
    for (std::size_t i = 0; i < place.cloud.size(); ++i) {
      const std::uint32_t label = place.cloud.points[i].label;
      const Eigen::Vector3d p = place.cloud.position(i);
      if (place.labels.role(label) == Role::ignored || !region_.contains(p)) continue;
      const ClassCell block = cellOf(p, kBlock_m, 0);
      all_.add(block, i);
      if (isGround(place.labels.kind(label))) continue;
      const GroundCell* cell = cellAt(inCells(p));
      if (cell && (place.bev.alignment * p).z() < place.bev.origin_z + cell->z + kAboveGround_m)
        continue;
      upright_.add(block, i);
      upright_points_.push_back(i);
    }
    for (std::size_t i = 0; i < place.graph.size(); ++i) {
      const Eigen::Vector3d& p = place.graph.vertices[i].position;
      if (region_.contains(p)) vertices_.add(cellOf(p, kNear_m, 0), i);
    }
    collectObjects();
  }

  bool tellsWhereItLooked() const { return !place_.bev.known.empty() && !place_.cloud.empty(); }
  std::vector<Object>& objects() { return objects_; }
  std::vector<Object>& rareObjects() { return rare_; }
  const std::vector<Object>& objects() const { return objects_; }
  const LabelSet& labels() const { return place_.labels; }

  /// Adds as landmarks what stands where the other visit met nothing, whatever its class: shapes
  /// call a box a wall.
  void addUnmet(const Visit& other) {
    std::vector<std::size_t> unmet;
    std::vector<Eigen::Vector3f> points;
    for (const std::size_t i : upright_points_) {
      const Eigen::Vector3d p = place_.cloud.position(i);
      if (other.meets(T_common_visit_ * p)) continue;
      unmet.push_back(i);
      points.push_back(p.cast<float>());
    }
    const std::vector<int> cluster_of_point = euclideanClusters(points, kJoined_m, kFewestOfThing);
    std::map<int, std::vector<std::size_t>> clusters;
    for (std::size_t k = 0; k < unmet.size(); ++k) {
      if (cluster_of_point[k] >= 0) clusters[cluster_of_point[k]].push_back(unmet[k]);
    }
    for (const auto& [number, members] : clusters) addThing(members);
  }

  /// Presence of all vertices, once the landmarks are judged.
  std::vector<Presence> presence() const {
    std::vector<Presence> of_vertex(place_.graph.size(), Presence::unknown);
    for (const std::vector<Object>* objects : {&objects_, &rare_}) {
      for (const Object& object : *objects) {
        const bool is_of_graph = !place_.graph.vertices.empty() &&
                                 object.vertex >= &place_.graph.vertices.front() &&
                                 object.vertex <= &place_.graph.vertices.back();
        if (!object.was_looked_at || !is_of_graph) continue;
        of_vertex[static_cast<std::size_t>(object.vertex - place_.graph.vertices.data())] =
            object.isChanged() ? Presence::gone : Presence::stands;
      }
    }
    return of_vertex;
  }

  /// Median label impurity of landmarks: share of the points within meet_m that have another class.
  double labelNoise() const {
    std::vector<double> purities;
    for (const Object& object : objects_) {
      if (object.points.size() >= kFewPoints) purities.push_back(purityOf(object));
    }
    return purities.empty() ? 0 : 1 - medianOf(std::move(purities));
  }

  /// Number of measurements of each class in the boxes of `parts`, by landmarks that are no posts.
  std::map<std::uint32_t, double> votesWithin(const std::vector<const Object*>& parts) const {
    std::map<std::uint32_t, double> votes;
    for (const Object* part : parts) votes.emplace(part->vertex->label, 0);
    for (const Object& object : objects_) {
      const auto touches = [&](const Object* part) { return part->box.intersects(object.box); };
      if (object.is_post || std::none_of(parts.begin(), parts.end(), touches)) continue;
      const auto inside =
          std::count_if(object.points.begin(), object.points.end(), [&](const Eigen::Vector3d& p) {
            return std::any_of(parts.begin(), parts.end(),
                               [&](const Object* part) { return part->box.contains(T_ * p); });
          });
      if (inside == 0) continue;
      votes[object.vertex->label] += static_cast<double>(inside) * object.vertex->points /
                                     static_cast<double>(object.points.size());
    }
    return votes;
  }

  /// Points within kBlock_m of the box of a landmark, but outside of it; common frame.
  std::vector<Eigen::Vector3d> pointsAround(const Object& object) const {
    const Eigen::Vector3d rim = Eigen::Vector3d::Constant(kBlock_m);
    const Eigen::AlignedBox3d wide(object.box.min() - rim, object.box.max() + rim);
    std::vector<Eigen::Vector3d> points;
    forPointsIn(all_, wide, [&](std::size_t, const Eigen::Vector3d& p) {
      if (!object.box.contains(p)) points.push_back(T_common_visit_ * p);
    });
    return points;
  }

  /// Fills in what this visit says of a landmark of the other visit and of the points around it.
  void judge(Object& object, const std::vector<Eigen::Vector3d>& around) const {
    const Vertex& v = *object.vertex;
    const bool on_seen_ground = isGroundSeen(object.position);
    object.evidence = ask(object.points, Eigen::Vector3d::Zero(), v.label, on_seen_ground);
    object.was_looked_at = object.evidence.suffices() && shareMet(around) >= kAroundShare;
    if (!object.was_looked_at) return;
    for (std::size_t i = 0; i < object.chance.size(); ++i) {
      const double angle = M_PI * (0.25 + 0.5 * static_cast<double>(i));
      const Eigen::Vector3d beside =
          kBeside_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
      object.chance[i] = ask(object.points, beside, v.label, on_seen_ground).metShare();
    }
    // The middle of a large thing depends on what of it was seen, the foot of a post does not.
    const double large_m = object.is_post ? 0 : v.extent.head<2>().maxCoeff() / 4;
    const double reach_m = kSameObject_m + meet_m_ - kMeet_m + large_m;
    object.is_matched = std::any_of(objects_.begin(), objects_.end(), [&](const Object& other) {
      return isSameThing(labels(), v.label, other.vertex->label) &&
             (other.position - object.position).norm() <= reach_m;
    });
  }

 private:
  void collectObjects() {
    for (const Vertex& v : place_.graph.vertices) {
      const Role role = labels().role(v.label);
      if ((role != Role::object && role != Role::dynamic) || !region_.contains(v.position))
        continue;
      Object object = objectOf(v, isPost(labels().kind(v.label)));
      findPoints(object);
      // A post is told by its shape, however rarely it was seen.
      (object.is_post || isSeenOften(v) ? objects_ : rare_).push_back(std::move(object));
    }
  }

  /// Without its points.
  Object objectOf(const Vertex& v, bool is_post) const {
    Object object;
    object.vertex = &v;
    object.is_post = is_post;
    object.is_dynamic = labels().role(v.label) == Role::dynamic;
    object.box = boxOf(v, is_post);
    object.position = T_common_visit_ * v.position;
    return object;
  }

  void addThing(const std::vector<std::size_t>& members) {
    Eigen::AlignedBox3d box;
    std::map<std::uint32_t, std::size_t> votes;
    for (const std::size_t i : members) {
      box.extend(place_.cloud.position(i));
      ++votes[place_.cloud.points[i].label];
    }
    const auto isKnown = [&](const Object& object) { return object.box.contains(box.center()); };
    if (box.sizes().maxCoeff() > kThing_m || std::any_of(objects_.begin(), objects_.end(), isKnown))
      return;
    Vertex& v = things_.emplace_back();
    v.label = std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
                return a.second < b.second;
              })->first;
    v.position = box.center();
    v.extent = box.sizes();
    v.points = static_cast<std::uint32_t>(members.size());
    Object& object = objects_.emplace_back(objectOf(v, false));
    for (const std::size_t i : members)
      object.points.push_back(T_common_visit_ * place_.cloud.position(i));
  }

  /// Whether anything of this visit is near a point of the common frame.
  bool meets(const Eigen::Vector3d& p_common) const {
    const Eigen::Vector3d p = T_ * p_common;
    return all_.anyAround(cellOf(p, kBlock_m, 0), [&](std::size_t i) {
      return (place_.cloud.position(i) - p).norm() <= meet_m_;
    });
  }

  /// By noise, a part of a thing has another label in a few of the frames that see it. How many see
  /// it is the 90 % quantile of the observations of vertices around it.
  bool isSeenOften(const Vertex& v) const {
    constexpr double kUsualQuantile = 0.9;
    std::vector<std::uint32_t> observations;
    vertices_.forAround(cellOf(v.position, kNear_m, 0), [&](std::size_t i) {
      const Vertex& other = place_.graph.vertices[i];
      if ((other.position - v.position).norm() <= kNear_m)
        observations.push_back(other.observations);
    });
    return v.observations >= kSeenOftenShare * quantileOf(observations, kUsualQuantile);
  }

  void findPoints(Object& object) const {
    std::vector<Eigen::Vector3d> of_class, of_any;
    forPointsIn(upright_, object.box, [&](std::size_t i, const Eigen::Vector3d& p) {
      const bool same = place_.cloud.points[i].label == object.vertex->label;
      (same ? of_class : of_any).push_back(T_common_visit_ * p);
    });
    // In noise a post may have points of other labels only.
    object.points = std::move(of_class.empty() && object.is_post ? of_any : of_class);
  }

  /// Share of the class of a landmark among the points within meet_m of its points.
  double purityOf(const Object& object) const {
    double met = 0, same = 0;
    for (const Eigen::Vector3d& p : someOf(object.points)) {
      forMet(T_ * p, [&](std::size_t i) {
        ++met;
        same += isSameThing(labels(), object.vertex->label, place_.cloud.points[i].label);
      });
    }
    return met > 0 ? same / met : 0;
  }

  static std::vector<Eigen::Vector3d> someOf(const std::vector<Eigen::Vector3d>& points) {
    const std::size_t step = 1 + points.size() / kAsked;
    std::vector<Eigen::Vector3d> some;
    for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
    return some;
  }

  /// Calls visit(i, p) for the points in a box, frame of the visit.
  template <class Take>
  void forPointsIn(const CellLists& blocks, const Eigen::AlignedBox3d& box, Take&& visit) const {
    const ClassCell low = cellOf(box.min(), kBlock_m, 0), high = cellOf(box.max(), kBlock_m, 0);
    for (auto z = low.z; z <= high.z; z += 3) {  // each call is about three cells a side
      for (auto y = low.y; y <= high.y; y += 3) {
        for (auto x = low.x; x <= high.x; x += 3) {
          blocks.forAround({x + 1, y + 1, z + 1, 0}, [&](std::size_t i) {
            const Eigen::Vector3d p = place_.cloud.position(i);
            if (box.contains(p)) visit(i, p);
          });
        }
      }
    }
  }

  /// Calls visit(i) for the points above the ground within meet_m of `p`.
  template <class Take>
  void forMet(const Eigen::Vector3d& p, Take&& visit) const {
    upright_.forAround(cellOf(p, kBlock_m, 0), [&](std::size_t i) {
      if ((place_.cloud.position(i) - p).norm() <= meet_m_) visit(i);
    });
  }

  Evidence ask(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& shift,
               std::uint32_t label, bool on_seen_ground) const {
    Evidence evidence;
    for (const Eigen::Vector3d& point : someOf(points)) {
      const Eigen::Vector3d p = T_ * (point + shift);
      bool is_met = false, is_same = false;
      forMet(p, [&](std::size_t i) {
        is_met = true;
        is_same = is_same || isSameThing(labels(), label, place_.cloud.points[i].label);
      });
      ++evidence.asked;
      if (is_met) {
        ++(is_same ? evidence.same : evidence.other);
      } else {
        const Sight::Ray ray = sight_.to(p, meet_m_);
        evidence.hidden += ray == Sight::Ray::blocked;
        evidence.free += ray == Sight::Ray::passes || (ray == Sight::Ray::open && on_seen_ground);
      }
    }
    return evidence;
  }

  double shareMet(const std::vector<Eigen::Vector3d>& points) const {
    const std::vector<Eigen::Vector3d> some = someOf(points);
    const auto met =
        std::count_if(some.begin(), some.end(), [&](const Eigen::Vector3d& p) { return meets(p); });
    return some.empty() ? 0 : static_cast<double>(met) / static_cast<double>(some.size());
  }

  /// True if ground was measured around a foot.
  bool isGroundSeen(const Eigen::Vector3d& p_common) const {
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
    return measured >= kGroundShare * all;
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
  Eigen::AlignedBox3d region_;  ///< where the other visit may have seen things
  Sight sight_;
  CellLists vertices_;       ///< this visit's frame
  CellLists all_, upright_;  ///< points, and those above the ground; this visit's frame
  std::vector<std::size_t> upright_points_;
  std::deque<Vertex> things_;  ///< those of addUnmet()
  std::vector<Object> objects_;
  std::vector<Object> rare_;  ///< not seen often
};

/// Shares of points that are met: of landmarks that stand, and of these points moved beside them.
class MatchStatistics {
 public:
  void add(const Visit& visit) {
    are_classes_shapes_ = are_classes_shapes_ || knowsShapesOnly(visit.labels());
    label_noise_ = std::max(label_noise_, visit.labelNoise());
    for (const Object& object : visit.objects()) {
      if (!object.was_looked_at) continue;
      if (object.is_matched) standing_.push_back(object.evidence.metShare());
      chance_.insert(chance_.end(), object.chance.begin(), object.chance.end());
    }
  }

  double labelNoise() const { return label_noise_; }

  /// Probability that a landmark is gone, given what the other visit says of its points. Classes
  /// that were taken from shapes differ with the side from which a thing was seen, so that points
  /// of another class are the same thing.
  double probabilityOfChange(const Evidence& evidence) const {
    const double gone = probabilityOfAbsence(evidence.metShare());
    return evidence.isOfAnotherClass() && !are_classes_shapes_
               ? std::max(gone, probabilityOfReplacement())
               : gone;
  }

 private:
  /// Labels that differ by noise do so of all points of a thing at once, as classifiers err.
  double probabilityOfReplacement() const {
    return kReplaced / (kReplaced + (1 - kReplaced) * std::max(kUnmet, label_noise_));
  }

  double probabilityOfAbsence(double met) const {
    if (met > kStandsShare) return 0;
    const auto so_little = [&](double m) { return m <= met; };
    const auto so_much = [&](double m) { return m >= met; };
    const double standing = shareOf(standing_, so_little, kUnmet);
    const double changed = shareOf(chance_, so_much, 1);
    return kChanged * changed / (kChanged * changed + (1 - kChanged) * standing);
  }

  template <class Condition>
  static double shareOf(const std::vector<double>& values, const Condition& condition,
                        double expected) {
    const auto count = std::count_if(values.begin(), values.end(), condition);
    return (static_cast<double>(count) + expected * kUnmetWeight) /
           (static_cast<double>(values.size()) + kUnmetWeight);
  }
  std::vector<double> standing_, chance_;
  double label_noise_ = 0;
  bool are_classes_shapes_ = false;
};

/// The changed objects that touch one another. A post stands for itself: its shape tells it.
std::vector<std::vector<const Object*>> regionsOf(const std::vector<Object>& objects) {
  std::vector<const Object*> changed;
  for (const Object& object : objects) {
    if (object.isChanged()) changed.push_back(&object);
  }
  std::vector<std::vector<const Object*>> regions;
  std::vector<bool> is_taken(changed.size(), false);
  for (std::size_t first = 0; first < changed.size(); ++first) {
    if (is_taken[first]) continue;
    is_taken[first] = true;
    std::vector<const Object*> region{changed[first]};
    for (std::size_t k = 0; k < region.size() && !region[k]->is_post; ++k) {
      for (std::size_t i = first + 1; i < changed.size(); ++i) {
        if (is_taken[i] || changed[i]->is_post || !changed[i]->box.intersects(region[k]->box))
          continue;
        is_taken[i] = true;
        region.push_back(changed[i]);
      }
    }
    regions.push_back(std::move(region));
  }
  return regions;
}

/// One change of all parts of a landmark; its largest part of class `label` tells what it is.
Change changeOf(const std::vector<const Object*>& parts, std::uint32_t label, Change::What what,
                double sigma_m) {
  const auto size = [&](const Object* part) {
    return std::make_pair(part->vertex->label == label, part->points.size());
  };
  const Object& largest =
      **std::max_element(parts.begin(), parts.end(),
                         [&](const Object* a, const Object* b) { return size(a) < size(b); });
  Change change;
  change.what = what;
  change.label = label;
  change.is_dynamic = largest.is_dynamic;
  change.sigma_m = std::hypot(largest.vertex->sigma_m, sigma_m);
  Eigen::AlignedBox3d box;
  double weight = 0;
  for (const Object* part : parts) {
    const double points = 1 + static_cast<double>(part->points.size());
    change.position += points * part->position;
    weight += points;
    box.extend(part->position - part->vertex->extent / 2);
    box.extend(part->position + part->vertex->extent / 2);
    change.probability = std::max(change.probability, part->changed);
  }
  change.position /= weight;
  change.extent = box.sizes();
  return change;
}

/// Each landmark once. Where labels are noisy, landmarks have parts of other classes: a class with
/// a share of the measurements in a region below `label_noise` counts as the most frequent class
/// there, and as no change if no landmark of that class has changed.
std::vector<Change> changesAmong(const Visit& visit, Change::What what, double label_noise,
                                 double sigma_m) {
  std::vector<Change> changes;
  for (const auto& region : regionsOf(visit.objects())) {
    if (region.front()->is_post) {
      changes.push_back(changeOf(region, region.front()->vertex->label, what, sigma_m));
      continue;
    }
    const std::map<std::uint32_t, double> votes = visit.votesWithin(region);
    double all = 0;
    for (const auto& [label, count] : votes) all += count;
    const std::uint32_t most =
        std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
          return a.second < b.second;
        })->first;
    std::map<std::uint32_t, std::vector<const Object*>> things;
    for (const Object* object : region) {
      const std::uint32_t label = object->vertex->label;
      things[votes.at(label) < label_noise * all ? most : label].push_back(object);
    }
    for (const auto& [label, parts] : things) {
      const bool has_changed =
          std::any_of(parts.begin(), parts.end(),
                      [of = label](const Object* part) { return part->vertex->label == of; });
      if (has_changed) changes.push_back(changeOf(parts, label, what, sigma_m));
    }
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
  for (Object& object : earlier.objects()) later.judge(object, earlier.pointsAround(object));
  for (Object& object : earlier.rareObjects()) later.judge(object, earlier.pointsAround(object));
  for (Object& object : later.objects()) earlier.judge(object, later.pointsAround(object));
  MatchStatistics statistics;
  statistics.add(earlier);
  statistics.add(later);
  for (std::vector<Object>* objects :
       {&earlier.objects(), &earlier.rareObjects(), &later.objects()}) {
    for (Object& object : *objects) {
      if (object.was_looked_at && !object.is_matched)
        object.changed = statistics.probabilityOfChange(object.evidence);
    }
  }
  result.presence = earlier.presence();
  const double noise = statistics.labelNoise();
  auto gone = changesAmong(earlier, Change::What::gone, noise, sigma_m);
  auto added = changesAmong(later, Change::What::added, noise, sigma_m);
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

}  // namespace

const char* toString(Change::What what) {
  static constexpr const char* kNames[] = {"gone", "new", "moved"};
  return kNames[static_cast<int>(what)];
}

Changes findChanges(const Place& earlier, const Place& later,
                    const Eigen::Isometry3d& T_earlier_later, double sigma_m) {
  const double size = earlier.size;
  requireNear("T_earlier_later", T_earlier_later, size);
  if (!(sigma_m >= 0)) throw UsageError("sigma_m must be >= 0");
  const Scaled<Place> earlier_town(earlier, 1 / size), later_town(later, 1 / size);
  Eigen::Isometry3d T = T_earlier_later;
  scaleLengths(1 / size, T);
  const double town_sigma_m = sigma_m / size;
  const double meet_m = std::min(kBlock_m, kMeet_m + 2 * town_sigma_m);
  Visit first(*earlier_town, Eigen::Isometry3d::Identity(), meet_m, seenBy(*later_town, T));
  Visit second(*later_town, T, meet_m, seenBy(*earlier_town, T.inverse()));
  if (knowsShapesOnly(earlier.labels)) {
    first.addUnmet(second);
    second.addUnmet(first);
  }
  Changes result = compare(first, second, town_sigma_m);
  for (Change& change : result.changes) {
    change.position *= size;
    change.extent *= size;
    change.sigma_m *= size;
    if (change.moved_to) *change.moved_to *= size;
  }
  return result;
}

}  // namespace xview
