// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/storeys_of_map.h"

#include <utility>

#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "place/storeys.h"

namespace xview {
namespace {

const Eigen::Quaterniond kUpright = Eigen::Quaterniond::Identity();

/// Calls visit(cloud) for all points of a map, packed ones too.
template <class Visit>
void forAllPoints(const map::SemanticMap& map, const Visit& visit) {
  map::forPoints(
      map, [](const PlaneCell&) { return true; },
      [&](const LabelledCloud& points) {
        if (points.empty()) return;
        LabelledCloud cloud = points;
        cloud.origin = map.cloud.origin;
        visit(cloud);
      });
}

StoreyOfMap partOf(const map::SemanticMap& map, const Storey& storey) {
  StoreyOfMap result;
  result.bottom = storey.bottom;
  map::SemanticMap& part = result.map;
  part.labels = map.labels;
  part.size = map.size;
  part.gravity = map.gravity;
  part.sensor = map.sensor;
  part.sources = map.sources;
  part.graph.space = map.graph.space;
  part.graph.edge_radius_m = map.graph.edge_radius_m;
  map::allVertices(map).forEach([&](std::uint32_t, const Vertex& vertex) {
    if (storey.holds(vertex.position.z())) part.graph.vertices.push_back(vertex);
  });
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    if (!storey.holds(map.poses[i].translation().z())) continue;
    part.addKeyframe(map.poses[i], 0, 0, i < map.source_of_pose.size() ? map.source_of_pose[i] : 0);
    result.key_frames.push_back(i);
  }
  forAllPoints(map, [&](const LabelledCloud& cloud) {
    part.cloud.append(pointsIn(storey, cloud, kUpright));
  });
  part.bev = viewOfThinned(part.cloud, part.labels, kUpright);
  return result;
}

std::unique_ptr<const search::Field> fieldOf(const search::MapView& view,
                                             const map::SemanticMap& map,
                                             const search::PathNull& known,
                                             const Options& options) {
  std::vector<Eigen::Vector3d> path;
  for (const Eigen::Isometry3d& T : map.poses) path.push_back(T.translation());
  return search::makeSurfaceField(view, path, surroundingsOf(map.size), known, options.places,
                                  options.threads);
}

}  // namespace

std::vector<StoreyOfMap> storeysOf(const map::SemanticMap& upright) {
  StoreyFinder finder(upright.poses, kUpright, upright.size);
  std::vector<StoreyOfMap> parts;
  if (finder.isOnePlane() || upright.bev.aerial) return parts;
  forAllPoints(upright, [&](const LabelledCloud& cloud) { finder.add(cloud, upright.labels); });
  for (const Storey& storey : finder.storeys()) parts.push_back(partOf(upright, storey));
  return parts;
}

std::unique_ptr<const search::Field> surfaceFieldOf(const map::SemanticMap& upright,
                                                    const Options& options,
                                                    const map::CommonDetail& detail) {
  std::vector<StoreyOfMap> storeys = storeysOf(upright);
  if (storeys.empty()) return fieldOf(map::searchedView(upright), upright, upright.null, options);
  std::vector<search::FieldAbove> fields;
  for (StoreyOfMap& storey : storeys) {
    map::reduceTo(detail, storey.map.bev);
    auto view = std::make_shared<const BevGrid>(std::move(storey.map.bev));
    fields.push_back({storey.bottom, fieldOf(*view, storey.map, {}, options), view});
  }
  return search::makeStackedField(std::move(fields));
}

}  // namespace xview
