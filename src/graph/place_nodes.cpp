// SPDX-License-Identifier: BSD-3-Clause
#include "graph/place_nodes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace xview::graph {
namespace {

constexpr double kLeastExtent_m = 0.3;  ///< boxes of thin things and of single views are no volume
constexpr double kLeastOverlap = 0.5;   ///< of the smaller box
constexpr std::size_t kSeldom = 4;      ///< together in one of so many frames, at most
constexpr std::size_t kLeastSeen = 3;   ///< frames of what may stand for others

bool boxesOverlap(const Vertex& a, const Vertex& b) {
  const Eigen::Array3d size_a = a.extent.array().max(kLeastExtent_m);
  const Eigen::Array3d size_b = b.extent.array().max(kLeastExtent_m);
  const Eigen::Array3d shift = (a.position - b.position).array().abs();
  const Eigen::Array3d common = ((size_a + size_b) / 2 - shift).min(size_a.min(size_b)).max(0.0);
  return common.prod() >= kLeastOverlap * std::min(size_a.prod(), size_b.prod());
}

bool seldomTogether(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::size_t together = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) ++together;
    const bool advance_a = *i <= *j, advance_b = *j <= *i;
    i += advance_a;
    j += advance_b;
  }
  return together * kSeldom <= std::min(a.size(), b.size());
}

double distance(const Node& a, const Node& b) {
  return (a.vertex.position - b.vertex.position).norm();
}

/// Nodes with frames, most frames first.
std::vector<std::size_t> byObservations(const std::vector<Node>& nodes) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].frames.empty()) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return nodes[a].frames.size() > nodes[b].frames.size();
  });
  return order;
}

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

void join(Node& node, const Node& other) {
  const Eigen::Vector3d shift = other.first - node.first;
  node.square_sum +=
      other.square_sum + 2 * shift.dot(other.sum) + other.weight * shift.squaredNorm();
  node.sum += other.sum + other.weight * shift;
  node.extent_sum += other.extent_sum;
  node.weight += other.weight;
  std::vector<std::int64_t> frames;
  std::set_union(node.frames.begin(), node.frames.end(), other.frames.begin(), other.frames.end(),
                 std::back_inserter(frames));
  node.frames = std::move(frames);
  node.vertex.position = node.first + node.meanOffset();
  node.vertex.extent = node.extent_sum / node.weight;
  node.vertex.points += other.vertex.points;
  node.vertex.observations = static_cast<std::uint32_t>(node.frames.size());
  node.vertex.first_frame = std::min(node.vertex.first_frame, other.vertex.first_frame);
  node.vertex.last_frame = std::max(node.vertex.last_frame, other.vertex.last_frame);
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

std::vector<std::size_t> sameThings(const std::vector<Node>& nodes, const LabelSet& labels,
                                    double reach_m) {
  std::vector<std::size_t> same(nodes.size());
  std::iota(same.begin(), same.end(), std::size_t{0});
  const auto mayBeSame = [&](const Node& a, const Node& b) {
    return a.vertex.label != b.vertex.label &&
           labels.role(a.vertex.label) == labels.role(b.vertex.label) &&
           distance(a, b) <= reach_m && boxesOverlap(a.vertex, b.vertex) &&
           seldomTogether(a.frames, b.frames);
  };
  CellLists leaders;
  for (const std::size_t i : byObservations(nodes)) {
    const ClassCell cell = cellOf(nodes[i].vertex.position, reach_m, 0);
    double nearest = std::numeric_limits<double>::infinity();
    leaders.forAround(cell, [&](std::size_t leader) {
      const double d = distance(nodes[i], nodes[leader]);
      if (d >= nearest || !mayBeSame(nodes[i], nodes[leader])) return;
      nearest = d;
      same[i] = leader;
    });
    if (same[i] == i && nodes[i].frames.size() >= kLeastSeen) leaders.add(cell, i);
  }
  return same;
}

}  // namespace xview::graph
