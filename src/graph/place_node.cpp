// SPDX-License-Identifier: BSD-3-Clause
#include "place_node.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace xview {

CellKey cellOf(const Eigen::Vector3d& p, double side, std::uint32_t label) {
  // Beyond 2^53 a double has no cells; whatever is there shares one.
  const auto index = [side](double c) {
    return static_cast<std::int64_t>(std::floor(std::clamp(c / side, -9e15, 9e15)));
  };
  return {index(p.x()), index(p.y()), index(p.z()), label};
}

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

}  // namespace xview
