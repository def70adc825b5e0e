// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "panel.h"

namespace xview {
namespace {

constexpr Color kRim{40, 40, 40};
constexpr Color kEdgeColor{196, 196, 200};
constexpr std::size_t kCrowded = 4000;  // vertices in view from which they shrink to dots
constexpr double kPointSize_m = 0.35;   // maps are thinned to about this distance

Eigen::Vector2d flat(const Eigen::Vector3d& p) { return p.head<2>(); }

/// 1, 2 or 5 times a power of ten, at most `length`.
double roundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

bool isSurface(const LabelSet& labels, const Vertex& v) {
  return labels.role(v.label) == Role::surface;
}

/// Without those of surfaces.
std::size_t verticesInView(const Panel& panel, const SemanticGraph& graph, const LabelSet& labels) {
  return static_cast<std::size_t>(std::count_if(
      graph.vertices.begin(), graph.vertices.end(),
      [&](const Vertex& v) { return !isSurface(labels, v) && panel.shows(flat(v.position)); }));
}

/// Vertices of surfaces are many and stand for nothing of their own: they are dots.
double vertexRadius(const LabelSet& labels, const Vertex& v, std::size_t in_view) {
  if (isSurface(labels, v)) return 1.5;
  return in_view > kCrowded ? 2 : in_view > kCrowded / 8 ? 3.2 : 4.5;
}

std::vector<Eigen::Vector2d> flat(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector2d> result;
  for (const Eigen::Vector3d& p : points) result.push_back(flat(p));
  return result;
}

/// Where the sensor looks, seen from above; zero if it looks up or down.
Eigen::Vector2d headingOf(const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& forward) {
  const Eigen::Vector2d heading = flat(T_map_sensor.linear() * forward.normalized());
  return heading.norm() < 0.3 ? Eigen::Vector2d::Zero() : Eigen::Vector2d(heading.normalized());
}

/// An arrow head, or a disc for a sensor that looks up or down.
void drawPose(Panel& panel, const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& forward,
              double radius_px, const Color& fill, const Color& rim, int rim_thickness) {
  const Eigen::Vector2d at = flat(T_map_sensor.translation()),
                        heading = headingOf(T_map_sensor, forward);
  if (!at.allFinite()) return;
  if (heading.isZero()) {
    panel.disc(at, 0.6 * radius_px, fill, rim);
  } else {
    panel.arrowHead(at, heading, radius_px, fill, rim, rim_thickness);
  }
}

struct MatchEnds {
  Eigen::Vector2d query, map;
};

std::optional<MatchEnds> endsOf(const SceneQuery& query, const Correspondence& c,
                                const SemanticGraph& map) {
  if (query.graph == nullptr || c.query >= query.graph->size() || c.map >= map.size())
    return std::nullopt;
  return MatchEnds{flat(query.T_map_query * query.graph->vertices[c.query].position),
                   flat(map.vertices[c.map].position)};
}

}  // namespace

void drawGrid(Panel& panel) {
  const double step = roundLength(240 / panel.pixelsPerMetre());
  const Eigen::AlignedBox2d& area = panel.area();
  for (double x = std::ceil(area.min().x() / step) * step; x < area.max().x(); x += step) {
    panel.line({x, area.min().y()}, {x, area.max().y()}, {232, 232, 232});
  }
  for (double y = std::ceil(area.min().y() / step) * step; y < area.max().y(); y += step) {
    panel.line({area.min().x(), y}, {area.max().x(), y}, {232, 232, 232});
  }
}

void drawPlan(Panel& panel, const PlanView& plan) {
  const Eigen::Vector2d origin(plan.origin_x, plan.origin_y);
  const double cell_px = plan.cell_m * panel.pixelsPerMetre();
  for (const Channel channel : drawnChannels()) {
    for (const PlanSample& s : plan[channel]) {
      const Eigen::Vector2d p = origin + Eigen::Vector2d(s.x, s.y);
      if (!panel.shows(p)) continue;
      if (isObject(channel)) {
        panel.disc(p, std::max(1.5, cell_px), channelColor(channel), kRim);
      } else {
        panel.fillSquare(p, std::max(1.0, isArea(channel) ? cell_px : 0.8 * cell_px),
                         channelColor(channel));
      }
    }
  }
}

void drawCloud(Panel& panel, const LabelledCloud& cloud, const LabelSet& labels,
               const Eigen::Isometry3d& T_map_cloud, double fade) {
  struct Splat {
    Eigen::Vector2d at;
    double z;
    std::uint32_t label;
  };
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = T_map_cloud * cloud.position(i);
    if (p.allFinite() && panel.shows(flat(p)))
      splats.push_back({flat(p), p.z(), cloud.points[i].label});
  }
  std::stable_sort(splats.begin(), splats.end(),
                   [](const Splat& a, const Splat& b) { return a.z < b.z; });
  const double side_px = std::max(1.0, kPointSize_m * panel.pixelsPerMetre());
  for (const Splat& s : splats) {
    const bool ground = isGround(labels.kind(s.label));
    panel.fillSquare(s.at, side_px, paler(labels.color(s.label), ground ? (1 + fade) / 2 : fade));
  }
}

void drawMapGraph(Panel& panel, const SemanticGraph& graph, const LabelSet& labels) {
  const std::size_t in_view = verticesInView(panel, graph, labels);
  if (in_view <= kCrowded) {
    for (const auto& [i, j] : readableEdges(graph)) {
      if (isSurface(labels, graph.vertices[i]) && isSurface(labels, graph.vertices[j])) continue;
      const Eigen::Vector2d a = flat(graph.vertices[i].position),
                            b = flat(graph.vertices[j].position);
      if (panel.shows(a) || panel.shows(b)) panel.line(a, b, kEdgeColor);
    }
  }
  for (const bool surfaces : {true, false}) {  // objects above surfaces
    for (const Vertex& v : graph.vertices) {
      const Eigen::Vector2d p = flat(v.position);
      if (isSurface(labels, v) != surfaces || !panel.shows(p)) continue;
      panel.disc(p, vertexRadius(labels, v, in_view), labels.color(v.label), kRim);
    }
  }
}

void drawKeyframes(Panel& panel, const std::vector<Eigen::Isometry3d>& poses) {
  for (const auto& piece : trajectoryPieces(poses)) {
    panel.polyline(flat(piece), kKeyframeColor, 2);
    for (const Eigen::Vector2d& p : flat(piece)) {
      if (panel.shows(p)) panel.disc(p, 2, kKeyframeColor, kKeyframeColor);
    }
  }
}

void drawPutative(Panel& panel, const SceneQuery& query, const SemanticGraph& map) {
  constexpr std::size_t kMost = 150;  // more hide the map
  const std::size_t step = 1 + query.putative.size() / kMost;
  for (std::size_t i = 0; i < query.putative.size(); i += step) {
    if (const auto ends = endsOf(query, query.putative[i], map))
      panel.line(ends->query, ends->map, kPutativeColor);
  }
}

void drawKept(Panel& panel, const SceneQuery& query, const SemanticGraph& map) {
  const int thickness = 2;
  for (const Correspondence& c : query.kept) {
    const auto ends = endsOf(query, c, map);
    if (!ends) continue;
    panel.line(ends->query, ends->map, kKeptColor, thickness);
    if (panel.shows(ends->map)) panel.ring(ends->map, 9, kKeptColor, thickness);
  }
}

void drawQueryGraph(Panel& panel, const SceneQuery& query, const LabelSet& labels) {
  if (query.graph == nullptr) return;
  for (const bool surfaces : {true, false}) {
    for (const Vertex& v : query.graph->vertices) {
      const Eigen::Vector2d p = flat(query.T_map_query * v.position);
      if (isSurface(labels, v) != surfaces || !p.allFinite() || !panel.shows(p)) continue;
      panel.diamond(p, (surfaces ? 2.5 : 5.5), labels.color(v.label),
                    surfaces ? labels.color(v.label) : kRim);
    }
  }
}

void drawQueryPoses(Panel& panel, const SceneQuery& query) {
  const Color color = statusColor(query.status);
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Isometry3d& T_odom_sensor : query.poses)
    poses.push_back(query.T_map_query * T_odom_sensor);
  for (const auto& piece : trajectoryPieces(query.true_poses)) {
    panel.dashedPolyline(flat(piece), kTruthColor, 2, 7);
  }
  for (const auto& piece : trajectoryPieces(poses)) panel.polyline(flat(piece), color, 3);
  if (!query.true_poses.empty()) {
    drawPose(panel, query.true_poses.back(), query.forward, 20, {255, 255, 255}, kTruthColor, 2);
  }
  if (!poses.empty()) drawPose(panel, poses.back(), query.forward, 17, color, {255, 255, 255}, 1);
}

void drawScaleBar(Panel& panel) {
  const double length_m = roundLength(0.3 * panel.width() / panel.pixelsPerMetre());
  const double metres_per_px = 1 / panel.pixelsPerMetre();
  const Eigen::Vector2d left = panel.area().min() + 22 * metres_per_px * Eigen::Vector2d(1, 1);
  const Eigen::Vector2d right = left + Eigen::Vector2d(length_m, 0), tick(0, 5 * metres_per_px);
  for (const auto& [color, thickness] :
       {std::pair(Color{255, 255, 255}, 5), std::pair(Color{30, 30, 30}, 2)}) {
    panel.line(left, right, color, thickness);
    panel.line(left - tick, left + tick, color, thickness);
    panel.line(right - tick, right + tick, color, thickness);
  }
  const std::string text =
      length_m >= 1000 ? fmt::format("{:g} km", length_m / 1000) : fmt::format("{:g} m", length_m);
  const Eigen::Vector2d at = panel.toPixel(left) - Eigen::Vector2d(0, 16);
  writeText(panel.pixels(), text, {cvRound(at.x()), cvRound(at.y())}, 17, {30, 30, 30});
}

}  // namespace xview
