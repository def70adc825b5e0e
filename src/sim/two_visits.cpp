// SPDX-License-Identifier: BSD-3-Clause
#include "two_visits.h"

#include <map>
#include <set>

namespace xview {
namespace {

constexpr double kFoot_m = 0.35;  // what is no higher above the lowest point is the foot

/// A thing: its triangles and the classes of its parts.
struct Thing {
  std::vector<std::size_t> triangles;
  std::set<std::uint16_t> labels;
  std::optional<ThingChange::What> change;
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

}  // namespace

TwoVisits withChanges(TriangleMesh world, const LabelSet& labels, double share, std::uint64_t seed,
                      const PlaceNear& placeNear) {
  TwoVisits visits;
  std::map<std::uint16_t, Thing> things;
  if (share > 0) things = thingsOf(world, labels);
  for (auto& [instance, thing] : things) {
    Random random(seed ^ 0x4348, instance);
    if (random.uniform() >= share) continue;
    const Eigen::Vector3d foot = footOf(thing, world);
    thing.change = static_cast<ThingChange::What>(random.below(3));
    Eigen::Vector3d to = foot;
    if (thing.change == ThingChange::What::moved) {
      const auto place = placeNear(foot, random);
      if (place) {
        thing.shift = (*place - foot).cast<float>();
        to = *place;
      } else {
        thing.change = ThingChange::What::gone;
      }
    }
    for (const std::uint16_t label : thing.labels)
      visits.changes.push_back({*thing.change, labels.className(label), foot, to});
  }
  using What = ThingChange::What;
  if (visits.changes.empty()) {
    visits.before = std::move(world);
    return visits;
  }
  visits.before = visitOf(world, things, false, [](What what) { return what != What::added; });
  visits.after = visitOf(world, things, true, [](What what) { return what != What::gone; });
  return visits;
}

}  // namespace xview
