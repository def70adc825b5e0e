// SPDX-License-Identifier: BSD-3-Clause
#include "view/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/median.h"
#include "drawing.h"
#include "place/edges.h"
#include "xview/base/labels.h"

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

struct KindColor {
  Kind kind;
  Color color;
};
constexpr KindColor kKindColors[] = {
    {Kind::road, {208, 210, 216}},       {Kind::sidewalk, {228, 224, 217}},
    {Kind::terrain, {222, 229, 206}},    {Kind::lane_marking, {250, 250, 250}},
    {Kind::building, {172, 154, 142}},   {Kind::fence, {196, 176, 152}},
    {Kind::vegetation, {163, 187, 140}}, {Kind::trunk, {126, 100, 76}},
    {Kind::pole, {74, 78, 90}},          {Kind::sign, {176, 134, 46}},
    {Kind::light, {176, 134, 46}},       {Kind::vehicle, {146, 152, 180}}};

/// In the order in which they are drawn: canopies cover what is below them, so they go first.
struct ChannelKind {
  BevChannel channel;
  Kind kind;
};
constexpr ChannelKind kDrawnChannels[] = {{BevChannel::canopy, Kind::vegetation},
                                          {BevChannel::terrain, Kind::terrain},
                                          {BevChannel::sidewalk, Kind::sidewalk},
                                          {BevChannel::road, Kind::road},
                                          {BevChannel::lane_marking, Kind::lane_marking},
                                          {BevChannel::low_vegetation, Kind::vegetation},
                                          {BevChannel::vehicle_surface, Kind::vehicle},
                                          {BevChannel::other_surface, Kind::other_surface},
                                          {BevChannel::fence, Kind::fence},
                                          {BevChannel::building, Kind::building},
                                          {BevChannel::wall_foot, Kind::building},
                                          {BevChannel::tree, Kind::trunk},
                                          {BevChannel::trunk, Kind::trunk},
                                          {BevChannel::vehicle, Kind::vehicle},
                                          {BevChannel::other_object, Kind::other_object},
                                          {BevChannel::pole_like, Kind::pole},
                                          {BevChannel::pole, Kind::pole},
                                          {BevChannel::sign, Kind::sign},
                                          {BevChannel::light, Kind::light}};

Color colorOf(Kind kind, const Color& of_others) {
  for (const KindColor& known : kKindColors) {
    if (known.kind == kind) return known.color;
  }
  return of_others;
}

}  // namespace

bool isCeiling(const LabelSet& labels, std::uint32_t id) {
  return foldedName(labels.className(id)) == "ceiling";
}

Color quietColor(const LabelSet& labels, std::uint32_t id) {
  constexpr double kWhite = 0.3;  // mixed into a colour of its own
  Color paler = labels.color(id);
  for (std::uint8_t& part : paler)
    part = static_cast<std::uint8_t>(std::lround(part + kWhite * (255 - part)));
  return colorOf(labels.kind(id), paler);
}

std::vector<DrawnBevChannel> drawnBevChannels(const BevGrid& bev) {
  std::vector<DrawnBevChannel> channels;
  for (const auto& [channel, kind] : kDrawnChannels) {
    if (bev[channel].empty()) continue;
    std::string name = toString(channel);
    std::replace(name.begin(), name.end(), '_', ' ');
    channels.push_back({channel, name, colorOf(kind, {190, 180, 196})});
  }
  return channels;
}

bool areNumbered(const std::vector<SceneQuery>& queries) {
  const auto isDrawn = [](const SceneQuery& query) { return query.cloud && query.has_pose; };
  return queries.size() > 1 && queries.size() <= kMostNumbered &&
         std::any_of(queries.begin(), queries.end(), isDrawn);
}

Color queryColor(const std::vector<SceneQuery>& queries, std::size_t i) {
  // None is that of a status: green, amber, red.
  constexpr Color kColors[] = {kQueryColor,   {142, 60, 192}, {0, 137, 154}, {214, 66, 140},
                               {122, 74, 30}, {107, 122, 0},  {26, 42, 112}, {47, 176, 232}};
  return areNumbered(queries) ? kColors[i % std::size(kColors)] : kQueryColor;
}

std::vector<Eigen::Isometry3d> posesInMap(const SceneQuery& query) {
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Isometry3d& T_odom_sensor : query.poses)
    poses.push_back(query.T_map_query * T_odom_sensor);
  return poses;
}

std::vector<MatchEnds> endsOf(const std::vector<Correspondence>& matches, const SceneQuery& query,
                              const SemanticGraph& map) {
  std::vector<MatchEnds> ends;
  for (const Correspondence& c : matches) {
    if (query.graph == nullptr || c.query >= query.graph->size() || c.map >= map.size()) continue;
    ends.push_back({query.T_map_query * query.graph->vertices[c.query].position,
                    map.vertices[c.map].position});
    if (!ends.back().query.allFinite() || !ends.back().map.allFinite()) ends.pop_back();
  }
  return ends;
}

std::vector<Correspondence> onlyPutative(const std::vector<Correspondence>& putative,
                                         const std::vector<Correspondence>& kept) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> kept_pairs;
  for (const Correspondence& c : kept) kept_pairs.insert({c.query, c.map});
  std::vector<Correspondence> rest;
  for (const Correspondence& c : putative) {
    if (kept_pairs.count({c.query, c.map}) == 0) rest.push_back(c);
  }
  return rest;
}

Color statusColor(Status status) {
  switch (status) {
    case Status::accepted:
      return {22, 138, 62};
    case Status::ambiguous:
      return {214, 130, 0};
    case Status::rejected:
      return {200, 40, 40};
  }
  return {128, 128, 128};
}

const LabelSet& labelsOf(const Scene& scene) {
  static const LabelSet kNone;
  return scene.labels ? *scene.labels : kNone;
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

ReadableEdges readableEdges(SemanticGraph graph) {
  makeEdges(graph);
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
  return {std::move(edges), graph.edgeCount()};
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
