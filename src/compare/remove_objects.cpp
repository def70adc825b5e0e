// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <vector>

#include "base/cells.h"
#include "compare/changes.h"
#include "landmark_box.h"
#include "xview/base/error.h"

namespace xview {
namespace {

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

void removeObjects(Place& place, const std::vector<std::size_t>& vertices) {
  for (const std::size_t i : vertices) {
    if (i >= place.graph.size()) throw UsageError("an object to be removed is not there");
  }
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
