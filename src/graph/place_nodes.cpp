// SPDX-License-Identifier: BSD-3-Clause
#include "graph/place_nodes.h"

#include <limits>

namespace xview::graph {
namespace {

void addPoint(Node& node, const Eigen::Vector3d& p, std::int64_t frame) {
  node.sum += p - node.first;
  node.weight += 1;
  node.min = node.min.cwiseMin(p);
  node.max = node.max.cwiseMax(p);
  ++node.vertex.points;
  countFrame(node.vertex, frame);
}

}  // namespace

void countFrame(Vertex& vertex, std::int64_t frame) {
  if (vertex.observations == 0) vertex.first_frame = frame;
  if (vertex.observations == 0 || vertex.last_frame != frame) ++vertex.observations;
  vertex.last_frame = frame;
}

std::size_t SurfaceCells::nodeOf(const ClassCell& cell, const Eigen::Vector3d& p,
                                 std::vector<Node>& nodes) {
  const auto makeNode = [&] {
    Node node;
    node.is_surface = true;
    node.first = node.min = node.max = p;
    node.vertex.label = cell.label;
    node.vertex.observations = 0;
    nodes.push_back(node);
    return NodeOfCell{cell, nodes.size() - 1};
  };
  return cells_[cells_.numberOf(cell, makeNode)].node;
}

void SurfaceCells::add(const LabelledCloud& cloud, const LabelSet& labels, std::int64_t frame,
                       std::vector<Node>& nodes) {
  ClassCell last_cell;
  std::size_t last_node = std::numeric_limits<std::size_t>::max();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint32_t label = cloud.points[i].label;
    const Eigen::Vector3d p = cloud.position(i);
    if (labels.role(label) != Role::surface || !p.allFinite()) continue;
    const ClassCell cell = cellOf(p, side_m_, label);
    // Neighbouring points mostly share their cell.
    if (last_node >= nodes.size() || !(cell == last_cell)) {
      last_node = nodeOf(cell, p, nodes);
      last_cell = cell;
    }
    addPoint(nodes[last_node], p, frame);
  }
}

}  // namespace xview::graph
