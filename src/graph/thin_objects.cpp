// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace xview::graph {
namespace {

constexpr double kSameThing_m = 2;  ///< between the foot of a post and the centre of its cluster
constexpr double kSamePost_m = 1.5;
constexpr double kBelow_cells = 1.5;  ///< from a peak to the middle of a cell of the same post

struct ThinChannel {
  Channel channel;
  Kind kind;
};
constexpr std::array<ThinChannel, 2> kOnPosts{
    {{Channel::sign, Kind::sign}, {Channel::light, Kind::light}}};

std::optional<std::uint32_t> firstClassOf(Kind kind, const LabelSet& labels) {
  for (const auto& [id, info] : labels.classes()) {
    if (labels.kind(id) == kind) return id;
  }
  return std::nullopt;
}

double planDistance(const PlanSample& a, const PlanSample& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// The vertices that are to be replaced.
class Clusters {
 public:
  Clusters(const LabelSet& labels, const Eigen::Quaterniond& upright)
      : labels_(labels), upright_(upright) {}

  void add(const Vertex& v) { vertices_.push_back({v, upright_ * v.position}); }

  /// A vertex of the kind at `p_plan`, with what is known of the nearest cluster above it.
  std::optional<Vertex> vertexAt(const Eigen::Vector3d& p_plan, Kind kind) const {
    const Known* nearest = nullptr;
    double best = kSameThing_m;
    for (const Known& known : vertices_) {
      const double d = (known.p_plan - p_plan).head<2>().norm();
      if (labels_.kind(known.vertex.label) != kind || d > best) continue;
      best = d;
      nearest = &known;
    }
    Vertex vertex;
    if (nearest) {
      vertex = nearest->vertex;
    } else if (const auto label = firstClassOf(kind, labels_)) {
      vertex.label = *label;
    } else {
      return std::nullopt;
    }
    vertex.position = upright_.conjugate() * p_plan;
    return vertex;
  }

 private:
  struct Known {
    Vertex vertex;
    Eigen::Vector3d p_plan;
  };
  const LabelSet& labels_;
  Eigen::Quaterniond upright_;
  std::vector<Known> vertices_;
};

bool isNear(const PlanSample& s, const std::vector<PlanSample>& others, double reach_m) {
  return std::any_of(others.begin(), others.end(),
                     [&](const PlanSample& o) { return planDistance(o, s) < reach_m; });
}

/// Posts by any label: where poles are, and where something stands below a sign, a light or nothing
/// that has a name. In noise a post has one label here and another one there.
std::vector<PlanSample> postsOf(const PlanView& plan) {
  std::vector<PlanSample> posts;
  for (const PlanSample& s : plan[Channel::pole_like]) {
    if (isNear(s, plan[Channel::pole], kSamePost_m) ||
        isNear(s, plan[Channel::obstacle_low], kBelow_cells * plan.cell_m))
      posts.push_back(s);
  }
  return posts;
}

}  // namespace

void placeThinObjects(SemanticGraph& graph, const PlanView& plan, const LabelSet& labels) {
  if (plan.known.empty()) return;
  Clusters clusters(labels, plan.upright);
  std::vector<Vertex> vertices;
  for (const Vertex& v : graph.vertices) {
    if (isPoleLike(labels.kind(v.label)))
      clusters.add(v);
    else
      vertices.push_back(v);
  }
  const Eigen::Vector3d origin(plan.origin_x, plan.origin_y, plan.origin_z);
  const auto place = [&](const std::vector<PlanSample>& samples, Kind kind) {
    for (const PlanSample& s : samples) {
      const auto vertex = clusters.vertexAt(origin + Eigen::Vector3d(s.x, s.y, s.z), kind);
      if (vertex) vertices.push_back(*vertex);
    }
  };
  place(postsOf(plan), Kind::pole);
  for (const ThinChannel& thin : kOnPosts) place(plan[thin.channel], thin.kind);
  graph.vertices = std::move(vertices);
  graph.neighbours.assign(graph.size(), {});
}

}  // namespace xview::graph
