// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/walk_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "xview/graph/edges.h"

namespace xview {
namespace {

/// Positions of kept vertices by class and cell of the spacing.
class SpacedVertices {
 public:
  explicit SpacedVertices(double spacing_m) : spacing_m_(spacing_m) {}

  bool addIfFree(const Vertex& v) {
    const Key at = keyOf(v);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = cells_.find({v.label, std::get<1>(at) + dx, std::get<2>(at) + dy});
        if (it == cells_.end()) continue;
        for (const Eigen::Vector3d& p : it->second) {
          if ((p - v.position).norm() <= spacing_m_) return false;
        }
      }
    }
    cells_[at].push_back(v.position);
    return true;
  }

 private:
  using Key = std::tuple<std::uint32_t, std::int64_t, std::int64_t>;
  Key keyOf(const Vertex& v) const {
    return {v.label, static_cast<std::int64_t>(std::floor(v.position.x() / spacing_m_)),
            static_cast<std::int64_t>(std::floor(v.position.y() / spacing_m_))};
  }
  double spacing_m_;
  std::map<Key, std::vector<Eigen::Vector3d>> cells_;
};

}  // namespace

WalkGraph walkGraph(const SemanticGraph& graph, const LabelSet& labels, const Options& options) {
  WalkGraph result;
  if (graph.space == GraphSpace::image) {
    result.graph = graph;
    result.source.resize(graph.size());
    std::iota(result.source.begin(), result.source.end(), 0u);
    return result;
  }
  SpacedVertices spaced(options.merge.first_observation_m);
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    const Vertex& v = graph.vertices[i];
    if (labels.role(v.label) == Role::surface && !spaced.addIfFree(v)) continue;
    result.graph.vertices.push_back(v);
    result.source.push_back(i);
  }
  connectByRadius(result.graph, options.edges);
  return result;
}

SemanticGraph inducedGraph(const SemanticGraph& graph, const std::vector<std::uint32_t>& numbers) {
  SemanticGraph part;
  part.space = graph.space;
  part.neighbours.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    part.vertices.push_back(graph.vertices[numbers[i]]);
    if (graph.space != GraphSpace::image) continue;
    for (const std::uint32_t j : graph.neighbours[numbers[i]]) {
      const auto at = std::lower_bound(numbers.begin(), numbers.end(), j);
      if (at != numbers.end() && *at == j)
        part.neighbours[i].push_back(static_cast<std::uint32_t>(at - numbers.begin()));
    }
  }
  return part;
}

std::vector<Eigen::Vector3d> positionsOf(const SemanticGraph& graph) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(graph.size());
  for (const Vertex& v : graph.vertices) positions.push_back(v.position);
  return positions;
}

}  // namespace xview
