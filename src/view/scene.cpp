// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "drawing.h"
#include "xview/types/median.h"

namespace xview {
namespace {

void collect(const SemanticGraph* graph, std::set<std::uint32_t>& ids) {
  if (graph == nullptr) return;
  for (const Vertex& v : graph->vertices) ids.insert(v.label);
}

void collect(const LabelledCloud* cloud, std::set<std::uint32_t>& ids) {
  if (cloud == nullptr) return;
  for (const auto& p : cloud->points) ids.insert(p.label);
}

constexpr std::size_t kMostPerVertex = 6, kShortest = 3;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

void addShortest(const SemanticGraph& graph, std::uint32_t i, std::vector<Edge>& edges) {
  std::vector<std::pair<double, std::uint32_t>> nearest;
  for (const std::uint32_t j : graph.neighbours[i]) {
    if (!graph.vertices[j].position.allFinite()) continue;
    nearest.emplace_back((graph.vertices[i].position - graph.vertices[j].position).squaredNorm(),
                         j);
  }
  const std::size_t count = std::min(kShortest, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count),
                    nearest.end());
  for (std::size_t k = 0; k < count; ++k) edges.emplace_back(std::minmax(i, nearest[k].second));
}

double longestStep(std::vector<double> steps) {
  constexpr double kAlwaysFine_m = 20, kTimesUsual = 5;
  if (steps.empty()) return kAlwaysFine_m;
  return std::max(kAlwaysFine_m, kTimesUsual * medianOf(std::move(steps)));
}

/// In the order in which they are drawn: canopies cover what is below them, so they go first.
constexpr std::pair<Channel, Color> kChannelColors[] = {  //
    {Channel::canopy, {176, 206, 150}},
    {Channel::terrain, {216, 230, 200}},
    {Channel::sidewalk, {232, 206, 222}},
    {Channel::road, {196, 186, 200}},
    {Channel::lane_marking, {255, 255, 255}},
    {Channel::low_vegetation, {120, 170, 90}},
    {Channel::vehicle_surface, {150, 170, 230}},
    {Channel::other_surface, {205, 205, 205}},
    {Channel::fence, {190, 140, 100}},
    {Channel::building, {150, 130, 120}},
    {Channel::wall_foot, {110, 90, 84}},
    {Channel::tree, {40, 110, 50}},
    {Channel::trunk, {40, 110, 50}},
    {Channel::vehicle, {60, 90, 200}},
    {Channel::other_object, {160, 60, 160}},
    {Channel::pole_like, {120, 120, 40}},
    {Channel::pole, {120, 120, 40}},
    {Channel::sign, {220, 180, 0}},
    {Channel::light, {240, 130, 20}}};

}  // namespace

Color paler(const Color& color, double share) {
  Color result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = static_cast<std::uint8_t>(std::lround(color[i] + share * (255 - color[i])));
  return result;
}

std::vector<Channel> drawnChannels() {
  std::vector<Channel> channels;
  for (const auto& entry : kChannelColors) channels.push_back(entry.first);
  return channels;
}

Color channelColor(Channel channel) {
  for (const auto& [drawn, color] : kChannelColors) {
    if (drawn == channel) return color;
  }
  return {205, 205, 205};
}

Color statusColor(Status status) {
  switch (status) {
    case Status::accepted:
      return {22, 130, 60};
    case Status::ambiguous:
      return {214, 130, 0};
    case Status::rejected:
      return {200, 40, 40};
  }
  return {128, 128, 128};
}

std::vector<std::uint32_t> classesIn(const Scene& scene) {
  std::set<std::uint32_t> ids;
  collect(scene.map_graph, ids);
  collect(scene.map_cloud, ids);
  for (const SceneQuery& query : scene.queries) {
    collect(query.graph, ids);
    collect(query.cloud, ids);
  }
  std::vector<std::uint32_t> present;
  for (const std::uint32_t id : ids) {
    const bool ignored = scene.labels != nullptr && scene.labels->find(id) != nullptr &&
                         scene.labels->role(id) == Role::ignored;
    if (!ignored) present.push_back(id);
  }
  return present;
}

std::vector<Edge> readableEdges(const SemanticGraph& graph) {
  std::vector<Edge> edges;
  if (graph.edgeCount() <= kMostPerVertex * graph.size()) {
    edges = graph.edges();
  } else {
    for (std::uint32_t i = 0; i < graph.size(); ++i) {
      if (graph.vertices[i].position.allFinite()) addShortest(graph, i, edges);
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }
  const auto isBroken = [&](const Edge& e) {
    return !graph.vertices[e.first].position.allFinite() ||
           !graph.vertices[e.second].position.allFinite();
  };
  edges.erase(std::remove_if(edges.begin(), edges.end(), isBroken), edges.end());
  return edges;
}

std::vector<std::vector<Eigen::Vector3d>> trajectoryPieces(
    const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i)
    steps.push_back((poses[i].translation() - poses[i - 1].translation()).norm());
  const double longest = longestStep(steps);
  std::vector<std::vector<Eigen::Vector3d>> pieces;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i == 0 || !(steps[i - 1] <= longest)) pieces.emplace_back();
    pieces.back().push_back(poses[i].translation());
  }
  return pieces;
}

}  // namespace xview
