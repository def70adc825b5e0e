// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "base/random.h"
#include "xview/base/graph.h"

namespace xview::match {

/// `size` vertices with labels 10, 11, …; each pair is joined with probability `density`.
inline SemanticGraph randomGraph(std::uint32_t size, std::uint32_t classes, double density,
                                 std::uint64_t seed) {
  Random random(seed);
  SemanticGraph graph;
  graph.vertices.resize(size);
  for (Vertex& vertex : graph.vertices) vertex.label = 10 + random.below(classes);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < size; ++i) {
    for (std::uint32_t j = i + 1; j < size; ++j) {
      if (random.uniform() < density) edges.emplace_back(i, j);
    }
  }
  graph.setEdges(edges);
  return graph;
}

/// Vertices with these labels and edges.
inline SemanticGraph graphOf(const std::vector<std::uint32_t>& labels,
                             const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges) {
  SemanticGraph graph;
  graph.vertices.resize(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) graph.vertices[i].label = labels[i];
  graph.setEdges(edges);
  return graph;
}

/// The same graph with vertex i renamed to order[i].
inline SemanticGraph renumbered(const SemanticGraph& graph,
                                const std::vector<std::uint32_t>& order) {
  SemanticGraph result;
  result.vertices.resize(graph.size());
  for (std::uint32_t i = 0; i < graph.size(); ++i) result.vertices[order[i]] = graph.vertices[i];
  auto edges = graph.edges();
  for (auto& [a, b] : edges) {
    a = order[a];
    b = order[b];
  }
  result.setEdges(edges);
  return result;
}

}  // namespace xview::match
