// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/thin_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace xview {
namespace {

constexpr double kSameThing_m = 2;  ///< between the foot of a post and the centre of its cluster
constexpr double kSamePost_m = 1.5;

struct ThinChannel {
  Channel channel;
  Kind kind;
};
constexpr std::array<ThinChannel, 3> kThin{
    {{Channel::pole, Kind::pole}, {Channel::sign, Kind::sign}, {Channel::light, Kind::light}}};

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

/// Posts that are in none of the channels of a label.
std::vector<PlanSample> unlabelledPosts(const PlanView& plan) {
  std::vector<PlanSample> result;
  for (const PlanSample& post : plan[Channel::pole_like]) {
    const bool is_labelled = std::any_of(kThin.begin(), kThin.end(), [&](const ThinChannel& thin) {
      const auto& samples = plan[thin.channel];
      return std::any_of(samples.begin(), samples.end(),
                         [&](const PlanSample& s) { return planDistance(s, post) < kSamePost_m; });
    });
    if (!is_labelled) result.push_back(post);
  }
  return result;
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
  for (const ThinChannel& thin : kThin) place(plan[thin.channel], thin.kind);
  place(unlabelledPosts(plan), Kind::pole);
  graph.vertices = std::move(vertices);
  graph.neighbours.assign(graph.size(), {});
}

}  // namespace xview
