// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/graph.h"

#include <algorithm>

namespace xview {

const char* toString(GraphSpace space) { return space == GraphSpace::image ? "image" : "cloud"; }

std::size_t SemanticGraph::edgeCount() const {
  std::size_t ends = 0;
  for (const auto& list : neighbours) ends += list.size();
  return ends / 2;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> SemanticGraph::edges() const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
  for (std::uint32_t i = 0; i < neighbours.size(); ++i) {
    for (const std::uint32_t j : neighbours[i]) {
      if (i < j) result.emplace_back(i, j);
    }
  }
  return result;
}

void SemanticGraph::setEdges(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges) {
  edge_radius_m = 0;
  neighbours.assign(vertices.size(), {});
  for (const auto& [a, b] : edges) {
    if (a == b) continue;
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
}

bool isConsistent(const SemanticGraph& graph) {
  const auto& lists = graph.neighbours;
  if (graph.edge_radius_m > 0 && lists.empty()) return true;
  if (lists.size() != graph.vertices.size()) return false;
  for (std::uint32_t i = 0; i < lists.size(); ++i) {
    if (std::adjacent_find(lists[i].begin(), lists[i].end(), std::greater_equal<>()) !=
        lists[i].end())
      return false;
    for (const std::uint32_t j : lists[i]) {
      if (j == i || j >= lists.size()) return false;
      if (!std::binary_search(lists[j].begin(), lists[j].end(), i)) return false;
    }
  }
  return true;
}

std::size_t componentCount(const SemanticGraph& graph) {
  std::vector<bool> seen(graph.size(), false);
  std::vector<std::uint32_t> stack;
  std::size_t components = 0;
  for (std::uint32_t start = 0; start < graph.size(); ++start) {
    if (seen[start]) continue;
    ++components;
    seen[start] = true;
    stack.push_back(start);
    while (!stack.empty()) {
      const std::uint32_t i = stack.back();
      stack.pop_back();
      for (const std::uint32_t j : graph.neighbours[i]) {
        if (!seen[j]) {
          seen[j] = true;
          stack.push_back(j);
        }
      }
    }
  }
  return components;
}

}  // namespace xview
