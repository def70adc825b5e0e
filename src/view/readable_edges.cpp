// SPDX-License-Identifier: BSD-3-Clause
#include "readable_edges.h"

#include <algorithm>

namespace xview {
namespace {

constexpr std::size_t kMostPerVertex = 6, kShortest = 3;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

void addShortest(const SemanticGraph& graph, std::uint32_t i, std::vector<Edge>& edges) {
  std::vector<std::pair<double, std::uint32_t>> nearest;
  for (const std::uint32_t j : graph.neighbours[i]) {
    if (!graph.vertices[j].position.allFinite()) continue;
    nearest.emplace_back((graph.vertices[i].position - graph.vertices[j].position).squaredNorm(),
                         j);
  }
  const std::size_t count = std::min(kShortest, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count),
                    nearest.end());
  for (std::size_t k = 0; k < count; ++k) edges.emplace_back(std::minmax(i, nearest[k].second));
}

}  // namespace

std::vector<Edge> readableEdges(const SemanticGraph& graph) {
  std::vector<Edge> edges;
  if (graph.edgeCount() <= kMostPerVertex * graph.size()) {
    edges = graph.edges();
  } else {
    for (std::uint32_t i = 0; i < graph.size(); ++i) {
      if (graph.vertices[i].position.allFinite()) addShortest(graph, i, edges);
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }
  const auto isBroken = [&](const Edge& e) {
    return !graph.vertices[e.first].position.allFinite() ||
           !graph.vertices[e.second].position.allFinite();
  };
  edges.erase(std::remove_if(edges.begin(), edges.end(), isBroken), edges.end());
  return edges;
}

}  // namespace xview
