// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/edges.h"

#include <utility>

#include "xview/types/cells.h"

namespace xview::graph {

void connectByRadius(SemanticGraph& graph, const EdgeOptions& options) {
  const std::vector<Vertex>& vertices = graph.vertices;
  const double side_m = options.radius_m * (1 + 1e-9);  // rounding parts no neighbours by two cells
  CellLists before;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3d& p = vertices[i].position;
    if (!p.allFinite()) continue;
    const ClassCell cell = cellOf(p, side_m, 0);
    before.forAround(cell, [&](std::size_t j) {
      if ((vertices[j].position - p).squaredNorm() <= options.radius_m * options.radius_m)
        edges.emplace_back(static_cast<std::uint32_t>(j), i);
    });
    before.add(cell, i);
  }
  graph.setEdges(edges);
}

}  // namespace xview::graph
