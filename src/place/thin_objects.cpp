// SPDX-License-Identifier: BSD-3-Clause
#include "place/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace xview {
namespace {

constexpr double kSameObject_m = 2;  ///< between the foot of a post and the centre of its cluster
constexpr double kSamePost_m = 1.5;
constexpr double kBelow_cells = 1.5;  ///< from a peak to the middle of a cell of the same post

struct ThinBevChannel {
  BevChannel channel;
  Kind kind;
};
constexpr std::array<ThinBevChannel, 2> kOnPosts{
    {{BevChannel::sign, Kind::sign}, {BevChannel::light, Kind::light}}};

std::optional<std::uint32_t> firstClassOf(Kind kind, const LabelSet& labels) {
  for (const auto& [id, info] : labels.classes()) {
    if (labels.kind(id) == kind) return id;
  }
  return std::nullopt;
}

double bevDistance(const BevSample& a, const BevSample& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// The vertices that are to be replaced.
class Clusters {
 public:
  Clusters(const LabelSet& labels, const Eigen::Quaterniond& upright)
      : labels_(labels), upright_(upright) {}

  void add(const Vertex& v) { vertices_.push_back({v, upright_ * v.position}); }

  /// A vertex of the kind at `p_bev`, with what is known of the nearest cluster above it.
  std::optional<Vertex> vertexAt(const Eigen::Vector3d& p_bev, Kind kind) const {
    const Known* nearest = nullptr;
    double best = kSameObject_m;
    for (const Known& known : vertices_) {
      const double d = (known.p_bev - p_bev).head<2>().norm();
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
    vertex.position = upright_.conjugate() * p_bev;
    return vertex;
  }

 private:
  struct Known {
    Vertex vertex;
    Eigen::Vector3d p_bev;
  };
  const LabelSet& labels_;
  Eigen::Quaterniond upright_;
  std::vector<Known> vertices_;
};

bool isNear(const BevSample& s, const std::vector<BevSample>& others, double reach_m) {
  return std::any_of(others.begin(), others.end(),
                     [&](const BevSample& o) { return bevDistance(o, s) < reach_m; });
}

/// Posts by any label: where poles are, and where something stands below a sign, a light or nothing
/// that has a name. In noise a post has one label here and another one there.
std::vector<BevSample> postsOf(const BevGrid& bev) {
  std::vector<BevSample> posts;
  for (const BevSample& s : bev[BevChannel::pole_like]) {
    if (isNear(s, bev[BevChannel::pole], kSamePost_m) ||
        isNear(s, bev[BevChannel::obstacle_low], kBelow_cells * bev.cell_m))
      posts.push_back(s);
  }
  return posts;
}

}  // namespace

void placeThinObjects(SemanticGraph& graph, const BevGrid& bev, const LabelSet& labels) {
  if (bev.known.empty()) return;
  Clusters clusters(labels, bev.alignment);
  std::vector<Vertex> vertices;
  for (const Vertex& v : graph.vertices) {
    if (isPoleLike(labels.kind(v.label)))
      clusters.add(v);
    else
      vertices.push_back(v);
  }
  const Eigen::Vector3d origin(bev.origin_x, bev.origin_y, bev.origin_z);
  const auto place = [&](const std::vector<BevSample>& samples, Kind kind) {
    for (const BevSample& s : samples) {
      const auto vertex = clusters.vertexAt(origin + Eigen::Vector3d(s.x, s.y, s.z), kind);
      if (vertex) vertices.push_back(*vertex);
    }
  };
  place(postsOf(bev), Kind::pole);
  for (const ThinBevChannel& thin : kOnPosts) place(bev[thin.channel], thin.kind);
  graph.vertices = std::move(vertices);
  graph.neighbours.assign(graph.size(), {});
}

}  // namespace xview
