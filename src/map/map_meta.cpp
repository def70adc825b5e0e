// SPDX-License-Identifier: BSD-3-Clause
#include "map_meta.h"

#include <cmath>

#include "plan_tiles.h"

namespace xview {
namespace {

template <class Number>
std::string textOf(Number value) {
  char text[64];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace

Meta metaOf(const SemanticMap& map, std::size_t stored_points) {
  return {{"graph_space", toString(map.graph.space)},
          {"program_version", XVIEW_VERSION},
          {"label_set", map.labels.name()},
          {"options", map.options_yaml},
          {"vertices", textOf(map.graph.size())},
          {"edges", textOf(map.graph.edgeCount())},
          {"keyframes", textOf(map.poses.size())},
          {"cloud_points", textOf(stored_points)},
          {"cloud_instances", textOf(map.cloud.hasInstances() ? 1 : 0)},
          {"cloud_origin_x", textOf(map.cloud.origin.x())},
          {"cloud_origin_y", textOf(map.cloud.origin.y())},
          {"cloud_origin_z", textOf(map.cloud.origin.z())},
          {"plan_samples", textOf(map.plan.sampleCount())},
          {"plan_channels", channelNames()},
          {"plan_cell_m", textOf(map.plan.cell_m)},
          {"plan_origin_x", textOf(map.plan.origin_x)},
          {"plan_origin_y", textOf(map.plan.origin_y)},
          {"plan_origin_z", textOf(map.plan.origin_z)},
          {"plan_aerial", textOf(map.plan.aerial ? 1 : 0)},
          {"plan_upright_w", textOf(map.plan.upright.w())},
          {"plan_upright_x", textOf(map.plan.upright.x())},
          {"plan_upright_y", textOf(map.plan.upright.y())},
          {"plan_upright_z", textOf(map.plan.upright.z())}};
}

const std::string& textIn(const Meta& meta, const std::string& name) {
  const auto found = meta.find(name);
  if (found == meta.end()) throw Damage("meta: no " + name);
  return found->second;
}

double finiteIn(const Meta& meta, const std::string& name) {
  const double value = numberIn<double>(meta, name);
  if (!std::isfinite(value)) throw Damage("meta: " + name + " is not finite");
  return value;
}

void requireCount(const Meta& meta, const std::string& name, std::size_t found) {
  const auto expected = numberIn<std::size_t>(meta, name);
  if (found != expected) {
    throw Damage(name + ": expected " + std::to_string(expected) + ", found " +
                 std::to_string(found));
  }
}

}  // namespace xview
