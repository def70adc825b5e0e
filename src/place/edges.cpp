// SPDX-License-Identifier: BSD-3-Clause
#include "place/edges.h"

#include <pcl/kdtree/kdtree_flann.h>

#include <algorithm>
#include <limits>

#include "base/cells.h"

namespace xview {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// The finite vertices in single precision around their mean, and where they came from.
struct CentredVertices {
  pcl::PointCloud<pcl::PointXYZ>::Ptr points{new pcl::PointCloud<pcl::PointXYZ>};
  std::vector<std::uint32_t> vertex_of_point;
  float largest_coordinate = 0;
};

CentredVertices centred(const std::vector<Vertex>& vertices) {
  CentredVertices result;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    if (!vertices[i].position.allFinite()) continue;
    sum += vertices[i].position;
    result.vertex_of_point.push_back(i);
  }
  if (result.vertex_of_point.empty()) return result;
  const Eigen::Vector3d centre = sum / static_cast<double>(result.vertex_of_point.size());
  for (const std::uint32_t i : result.vertex_of_point) {
    const Eigen::Vector3f p = (vertices[i].position - centre).cast<float>();
    result.points->push_back({p.x(), p.y(), p.z()});
    result.largest_coordinate = std::max(result.largest_coordinate, p.cwiseAbs().maxCoeff());
  }
  return result;
}

/// Pairs of vertices; see connectByRadius().
std::vector<Edge> edgesOf(const std::vector<Vertex>& vertices, double radius_m, int nearest) {
  std::vector<Edge> edges;
  const CentredVertices centre = centred(vertices);
  if (centre.vertex_of_point.size() < 2) return edges;

  pcl::KdTreeFLANN<pcl::PointXYZ> tree(false);
  tree.setInputCloud(centre.points);
  // FLANN searches in single precision and strictly inside the radius: search a little wider,
  // decide in double.
  const double rounding_m = 8.0 * centre.largest_coordinate * std::numeric_limits<float>::epsilon();
  const double search_m = radius_m * (1 + 1e-5) + rounding_m;
  const double radius2 = radius_m * radius_m;

  pcl::Indices found;
  std::vector<float> distances2;
  for (std::size_t n = 0; n < centre.vertex_of_point.size(); ++n) {
    const std::uint32_t self = centre.vertex_of_point[n];
    if (nearest > 0)
      tree.nearestKSearch(static_cast<int>(n), nearest + 1, found, distances2);
    else
      tree.radiusSearch(static_cast<int>(n), search_m, found, distances2);
    for (const auto index : found) {
      const std::uint32_t other = centre.vertex_of_point[static_cast<std::size_t>(index)];
      if (other == self || (nearest == 0 && other < self)) continue;  // found from both ends
      const double d2 = (vertices[other].position - vertices[self].position).squaredNorm();
      if (d2 <= radius2) edges.emplace_back(self, other);
    }
  }
  return edges;
}

}  // namespace

void connectByRadius(SemanticGraph& graph, const EdgeOptions& options, int nearest) {
  graph.setEdges(edgesOf(graph.vertices, options.radius_m, nearest));
  if (nearest == 0) graph.edge_radius_m = options.radius_m;
}

void useRadius(SemanticGraph& graph, const EdgeOptions& options) {
  graph.neighbours.clear();
  graph.edge_radius_m = options.radius_m;
}

void makeEdges(SemanticGraph& graph) {
  if (graph.edge_radius_m > 0 && graph.neighbours.empty())
    connectByRadius(graph, {graph.edge_radius_m});
}

EdgeCount countEdges(const SemanticGraph& graph) {
  if (graph.edge_radius_m <= 0 || !graph.neighbours.empty())
    return {graph.edgeCount(), componentCount(graph)};
  struct Column {
    PlaneCell key;
    std::vector<std::uint32_t> vertices;
  };
  const double side_m = graph.edge_radius_m * (1 + 1e-3);  // whatever is rounded
  CellTable<Column> columns;
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (!graph.vertices[i].position.allFinite()) continue;
    const ClassCell cell = cellOf(graph.vertices[i].position, side_m, 0);
    const PlaneCell at{cell.x, cell.y};
    columns[columns.numberOf(at, [&] { return Column{at, {}}; })].vertices.push_back(i);
  }
  EdgeCount count{0, graph.size()};
  DisjointSets parts(graph.size());
  const double radius2 = graph.edge_radius_m * graph.edge_radius_m;
  const auto visitPair = [&](std::uint32_t a, std::uint32_t b) {
    if ((graph.vertices[a].position - graph.vertices[b].position).squaredNorm() > radius2) return;
    ++count.edges;
    if (parts.find(a) == parts.find(b)) return;
    parts.unite(a, b);
    --count.parts;
  };
  constexpr PlaneCell kLater[] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};  // the others come from there
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Column& column = columns[c];
    for (std::size_t i = 0; i < column.vertices.size(); ++i) {
      for (std::size_t j = i + 1; j < column.vertices.size(); ++j)
        visitPair(column.vertices[i], column.vertices[j]);
    }
    for (const PlaneCell& step : kLater) {
      const std::int32_t beside = columns.find({column.key.x + step.x, column.key.y + step.y});
      if (beside < 0) continue;
      for (const std::uint32_t a : column.vertices) {
        for (const std::uint32_t b : columns[static_cast<std::size_t>(beside)].vertices)
          visitPair(a, b);
      }
    }
  }
  return count;
}

}  // namespace xview
