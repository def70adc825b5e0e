// SPDX-License-Identifier: BSD-3-Clause
#include "surface_cells.h"

#include <limits>

namespace xview {
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

std::size_t SurfaceCells::nodeOf(const CellKey& key, const Eigen::Vector3d& p,
                                 std::vector<Node>& nodes) {
  const auto [place, is_new] = node_of_cell_.try_emplace(key, nodes.size());
  if (is_new) {
    Node node;
    node.is_surface = true;
    node.first = node.min = node.max = p;
    node.vertex.label = key.label;
    node.vertex.observations = 0;
    nodes.push_back(node);
  }
  return place->second;
}

void SurfaceCells::add(const LabelledCloud& cloud, const LabelSet& labels, std::int64_t frame,
                       std::vector<Node>& nodes) {
  std::uint32_t last_label = 0;
  bool last_is_surface = labels.role(last_label) == Role::surface;
  CellKey last_key;
  std::size_t last_node = std::numeric_limits<std::size_t>::max();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint32_t label = cloud.points.points[i].label;
    if (label != last_label) {
      last_label = label;
      last_is_surface = labels.role(label) == Role::surface;
    }
    const Eigen::Vector3d p = cloud.position(i);
    if (!last_is_surface || !p.allFinite()) continue;
    const CellKey key = cellOf(p, side_m_, label);
    // Neighbouring points mostly share their cell.
    if (last_node >= nodes.size() || !(key == last_key)) {
      last_node = nodeOf(key, p, nodes);
      last_key = key;
    }
    addPoint(nodes[last_node], p, frame);
  }
}

}  // namespace xview
