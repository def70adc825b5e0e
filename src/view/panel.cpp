// SPDX-License-Identifier: BSD-3-Clause
#include "panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace xview {
namespace {

constexpr Color kRim{52, 56, 66}, kWhite{255, 255, 255}, kGrid{226, 228, 232},
    kPanelInk{60, 64, 74};
constexpr std::size_t kCrowded = 4000;    // vertices in view from which they shrink to dots
constexpr double kLargestPoint_m = 0.35;  // maps of towns are thinned to about this distance

/// 1, 2 or 5 times a power of ten, at most `length`.
double roundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

std::uint32_t argb(const Color& c, double opacity = 1) {
  const auto part = [&](std::uint8_t value) {
    return static_cast<std::uint32_t>(std::lround(opacity * value));
  };
  return (part(255) << 24) | (part(c[0]) << 16) | (part(c[1]) << 8) | part(c[2]);
}

Eigen::AlignedBox2d inShapeOf(const Eigen::AlignedBox2d& box, const Eigen::AlignedBox2d& area) {
  const double aspect = box.sizes().x() / box.sizes().y();
  Eigen::Vector2d half = (area.sizes() / 2).cwiseMax(1e-3);
  if (half.x() < aspect * half.y())
    half.x() = aspect * half.y();
  else
    half.y() = half.x() / aspect;
  return {area.center() - half, area.center() + half};
}

/// Where the sensor looks, seen from above with y down; zero if it looks up or down.
Eigen::Vector2d headingOf(const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& forward) {
  const Eigen::Vector3d ahead = T_map_sensor.linear() * forward.normalized();
  const Eigen::Vector2d heading(ahead.x(), -ahead.y());
  return heading.norm() < 0.3 ? Eigen::Vector2d::Zero() : Eigen::Vector2d(heading.normalized());
}

/// About how far points are apart as seen from above, as long as that is less than in a map of a
/// town: halved cells are two to four times as many until they are smaller than that.
double pointSize(const LabelledCloud& cloud) {
  constexpr double kGrows = 1.6, kSmallest_m = 0.005;
  const auto filled = [&](double cell_m) {
    std::vector<std::pair<int, int>> cells;
    cells.reserve(cloud.size());
    for (const Point& p : cloud.points) {
      if (std::isfinite(p.x) && std::isfinite(p.y))
        cells.emplace_back(static_cast<int>(std::floor(p.x / cell_m)),
                           static_cast<int>(std::floor(p.y / cell_m)));
    }
    std::sort(cells.begin(), cells.end());
    return static_cast<double>(std::unique(cells.begin(), cells.end()) - cells.begin());
  };
  double cell_m = kLargestPoint_m;
  for (double count = filled(cell_m); cell_m > kSmallest_m; cell_m /= 2) {
    const double halved = filled(cell_m / 2);
    if (halved < kGrows * count) break;
    count = halved;
  }
  return std::min(2 * cell_m, kLargestPoint_m);  // so that surfaces have no gaps
}

}  // namespace

void drawArrowHead(Canvas& canvas, const Canvas::Point& at, const Eigen::Vector2d& direction,
                   double size, const Color& fill, const Color& rim) {
  if (direction.isZero()) return canvas.disc(at, 0.6 * size, fill, rim, 2);
  const Eigen::Vector2d ahead = size * direction.normalized(), aside(-ahead.y(), ahead.x());
  canvas.polygon({at + ahead, at - 0.8 * ahead + 0.72 * aside, at - 0.4 * ahead,
                  at - 0.8 * ahead - 0.72 * aside},
                 fill, rim, 2);
}

void drawDiamond(Canvas& canvas, const Canvas::Point& at, double radius, bool filled) {
  const Eigen::Vector2d x(radius, 0), y(0, radius);
  canvas.polygon({at + x, at + y, at - x, at - y}, filled ? kKeptColor : kWhite,
                 filled ? kWhite : kQueryColor, 1);
}

Panel::Panel(Canvas& canvas, const Eigen::AlignedBox2d& box, const Eigen::AlignedBox2d& area)
    : canvas_(canvas),
      box_(box),
      area_(inShapeOf(box, area)),
      scale_(box.sizes().x() / area_.sizes().x()) {}

bool Panel::shows(const Eigen::Vector3d& p) const {
  return p.allFinite() && area_.contains(Eigen::Vector2d(p.head<2>()));
}

Canvas::Point Panel::toPixel(const Eigen::Vector2d& p) const {
  return box_.min() + scale_ * Eigen::Vector2d(p.x() - area_.min().x(), area_.max().y() - p.y());
}

std::vector<Canvas::Point> Panel::toPixels(const std::vector<Eigen::Vector3d>& points) const {
  std::vector<Canvas::Point> pixels;
  for (const Eigen::Vector3d& p : points) pixels.push_back(toPixel(p));
  return pixels;
}

double Panel::gridStep() const { return roundLength(260 / scale_); }

void Panel::drawGrid() {
  canvas_.fill(box_, {249, 249, 247});
  const double step = gridStep();
  const Eigen::Vector2d low = area_.min(), high = area_.max();
  for (double x = std::ceil(low.x() / step) * step; x < high.x(); x += step)
    canvas_.line(toPixel(Eigen::Vector2d(x, low.y())), toPixel(Eigen::Vector2d(x, high.y())), kGrid,
                 1);
  for (double y = std::ceil(low.y() / step) * step; y < high.y(); y += step)
    canvas_.line(toPixel(Eigen::Vector2d(low.x(), y)), toPixel(Eigen::Vector2d(high.x(), y)), kGrid,
                 1);
}

/// Along the lower and the left edge.
void Panel::drawCoordinates() {
  constexpr double kSize = 13;
  constexpr Color kFaint{120, 124, 134};
  const double step = gridStep();
  const Eigen::Vector2d low = area_.min(), high = area_.max();
  const auto name = [&](double value) {
    return fmt::format("{:.{}f}", std::abs(value) < step / 2 ? 0 : value,
                       std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9))));
  };
  for (double x = std::ceil(low.x() / step) * step; x < high.x(); x += step) {
    const Canvas::Point at(toPixel(Eigen::Vector2d(x, 0)).x(), box_.max().y() - 12);
    if (at.x() > box_.min().x() + 60 && at.x() < box_.max().x() - 60)
      canvas_.text(name(x), at, kSize, kFaint, false, 0.5, true);
  }
  for (double y = std::ceil(low.y() / step) * step; y < high.y(); y += step) {
    const Canvas::Point at(box_.min().x() + 8, toPixel(Eigen::Vector2d(0, y)).y());
    if (at.y() > box_.min().y() + 30 && at.y() < box_.max().y() - 70)
      canvas_.text(name(y), at, kSize, kFaint, false, 0, true);
  }
  canvas_.text("x [m]", box_.max() - Eigen::Vector2d(8, 12), kSize, kFaint, false, 1, true);
  canvas_.text("y [m]", box_.min() + Eigen::Vector2d(8, 14), kSize, kFaint, false, 0, true);
}

void Panel::drawBev(const BevGrid& bev) {
  const double cell_px = bev.cell_m * scale_;
  for (const auto& [channel, name, color] : drawnBevChannels(bev)) {
    for (const BevSample& s : bev[channel]) {
      const Eigen::Vector3d p(bev.origin_x + s.x, bev.origin_y + s.y, 0);
      if (!shows(p)) continue;
      if (isObject(channel)) {
        canvas_.disc(toPixel(p), std::clamp(cell_px, 1.5, 4.0), color, kRim, 0);
      } else {
        const Eigen::Vector2d half =
            Eigen::Vector2d::Constant(std::max(1.0, isArea(channel) ? cell_px : 0.8 * cell_px) / 2);
        canvas_.fill({toPixel(p) - half, toPixel(p) + half}, color);
      }
    }
  }
}

/// Points as squares of `size_m` on a picture of the panel; argbOf(label) is what a class looks
/// like. The lowest come first.
template <class ColorOf>
void Panel::splat(const LabelledCloud& cloud, const Eigen::Isometry3d& T, double size_m,
                  ColorOf&& argbOf, std::vector<std::uint32_t>& pixels) const {
  const int width = static_cast<int>(box_.sizes().x()), height = static_cast<int>(box_.sizes().y());
  std::vector<std::pair<double, std::size_t>> lowest_first;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = T * cloud.position(i);
    if (shows(p)) lowest_first.emplace_back(p.z(), i);
  }
  std::sort(lowest_first.begin(), lowest_first.end());
  pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  const double half = std::max(1.0, size_m * scale_) / 2;
  const auto low = [&](double v) { return std::max(0, static_cast<int>(v - half + 0.5)); };
  const auto high = [&](double v, int least, int end) {
    return std::min(end, std::max(least + 1, static_cast<int>(v + half + 0.5)));
  };
  for (const auto& [z, i] : lowest_first) {
    const Canvas::Point at = toPixel(Eigen::Vector3d(T * cloud.position(i))) - box_.min();
    const std::uint32_t color = argbOf(cloud.points[i].label);
    if (color == 0) continue;
    const int x0 = low(at.x()), y0 = low(at.y());
    for (int y = y0, y1 = high(at.y(), y0, height); y < y1; ++y) {
      for (int x = x0, x1 = high(at.x(), x0, width); x < x1; ++x)
        pixels[static_cast<std::size_t>(y * width + x)] = color;
    }
  }
}

void Panel::drawCloud(const LabelledCloud& cloud, const LabelSet& labels) {
  std::vector<std::uint32_t> pixels;
  splat(
      cloud, Eigen::Isometry3d::Identity(), pointSize(cloud),
      [&](std::uint32_t label) {
        return isCeiling(labels, label) ? 0u : argb(quietColor(labels, label));
      },
      pixels);
  canvas_.image(pixels, static_cast<int>(box_.sizes().x()), box_.min());
}

/// The ground is only a shade, so that the map is seen through it, and things lie above it. What
/// was not accepted is paler: it need not be there.
void Panel::drawQueryClouds(const std::vector<SceneQuery>& queries, const LabelSet& labels) {
  std::vector<std::uint32_t> ground, things;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const SceneQuery& query = queries[i];
    if (query.cloud == nullptr || !query.has_pose) continue;
    const Color color = queryColor(queries, i);
    const auto argbOf = [&](bool of_ground, double opacity) {
      return [=, &labels](std::uint32_t label) {
        const bool is_drawn =
            isGround(labels.kind(label)) == of_ground && !isCeiling(labels, label);
        return is_drawn ? argb(color, opacity) : 0u;
      };
    };
    const double opacity = query.status == Status::accepted ? 0.8 : 0.35;
    const double size_m = pointSize(*query.cloud);
    splat(*query.cloud, query.T_map_query, size_m, argbOf(true, 0.2 * opacity), ground);
    splat(*query.cloud, query.T_map_query, size_m, argbOf(false, opacity), things);
  }
  for (const auto* pixels : {&ground, &things})
    canvas_.image(*pixels, static_cast<int>(box_.sizes().x()), box_.min());
}

void Panel::drawMapGraph(const SemanticGraph& graph, const LabelSet& labels, bool objects_only) {
  const auto isSurface = [&](std::uint32_t i) {
    return labels.role(graph.vertices[i].label) == Role::surface;
  };
  std::vector<std::uint32_t> visible;
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (shows(graph.vertices[i].position) && !(objects_only && isSurface(i))) visible.push_back(i);
  }
  const bool crowded = visible.size() > kCrowded;
  if (!objects_only && !crowded) {
    const ReadableEdges edges = readableEdges(graph);
    for (const auto& [i, j] : edges.shown) {
      const Eigen::Vector3d &a = graph.vertices[i].position, &b = graph.vertices[j].position;
      if (!(isSurface(i) && isSurface(j)) && (shows(a) || shows(b)))
        canvas_.line(toPixel(a), toPixel(b), {206, 208, 214}, 0.7);
    }
  }
  const double size = crowded ? 1.6 : objects_only ? 2.6 : 3.6;
  std::stable_partition(visible.begin(), visible.end(), isSurface);  // things above surfaces
  for (const std::uint32_t i : visible) {
    const Vertex& v = graph.vertices[i];
    const Color color = objects_only ? quietColor(labels, v.label) : labels.color(v.label);
    canvas_.disc(toPixel(v.position), isSurface(i) ? std::min(size, 2.2) : size, color, kRim,
                 crowded || isSurface(i) ? 0 : 0.6);
  }
}

void Panel::drawKeyframes(const std::vector<Eigen::Isometry3d>& poses) {
  for (const auto& piece : trajectoryPieces(poses))
    canvas_.polyline(toPixels(piece), kKeyframeColor, 1.4);
}

void Panel::drawLine(const SceneLine& line) {
  canvas_.polyline(toPixels(line.points), line.color, 2);
}

void Panel::drawMatches(const SceneQuery& query, const SemanticGraph& map, const LabelSet& labels) {
  if (query.graph == nullptr) return;
  for (const MatchEnds& ends : endsOf(query.kept, query, map))
    canvas_.line(toPixel(ends.query), toPixel(ends.map), kKeptColor, 2);
  std::set<std::uint32_t> kept;
  for (const Correspondence& c : query.kept) kept.insert(c.query);
  for (std::uint32_t i = 0; i < query.graph->size(); ++i) {
    const Vertex& v = query.graph->vertices[i];
    const bool surface = labels.role(v.label) == Role::surface, is_kept = kept.count(i) > 0;
    const Eigen::Vector3d p = query.T_map_query * v.position;
    if ((!surface || is_kept) && shows(p)) drawDiamond(canvas_, toPixel(p), 5.5, is_kept);
  }
}

void Panel::drawMarks(const std::vector<SceneMark>& marks) {
  for (const SceneMark& mark : marks) {
    if (shows(mark.at)) canvas_.disc(toPixel(mark.at), 3, mark.color, kWhite, 0.6);
  }
}

void Panel::drawWay(const SceneQuery& query) {
  for (const auto& piece : trajectoryPieces(query.true_poses))
    canvas_.polyline(toPixels(piece), kTruthColor, 2, 6);
  for (const auto& piece : trajectoryPieces(posesInMap(query)))
    canvas_.polyline(toPixels(piece), statusColor(query.status), 2.4);
}

void Panel::drawArrow(const SceneQuery& query, double size) {
  const auto draw = [&](const Eigen::Isometry3d& T_map_sensor, const Color& fill,
                        const Color& rim) {
    if (T_map_sensor.matrix().allFinite() && shows(T_map_sensor.translation()))
      drawArrowHead(canvas_, toPixel(Eigen::Vector3d(T_map_sensor.translation())),
                    headingOf(T_map_sensor, query.forward), size, fill, rim);
  };
  if (!query.true_poses.empty()) draw(query.true_poses.back(), kWhite, kTruthColor);
  if (!query.poses.empty())
    draw(query.T_map_query * query.poses.back(), statusColor(query.status), kWhite);
}

void Panel::drawNumber(const SceneQuery& query, std::size_t number, double size) {
  if (query.poses.empty()) return;
  const Eigen::Vector3d at = query.T_map_query * query.poses.back().translation();
  if (!shows(at)) return;
  canvas_.text(std::to_string(number), toPixel(at) + Eigen::Vector2d(size, -size), 17, kPanelInk,
               true, 0, true);
}

void Panel::drawScaleBar() {
  const double length_m = roundLength(std::max(120.0, 0.16 * box_.sizes().x()) / scale_);
  const Canvas::Point left(box_.min().x() + 22, box_.max().y() - 36),
      right = left + Eigen::Vector2d(length_m * scale_, 0), tick(0, 5);
  for (const auto& [color, width] : {std::pair(kWhite, 6.0), std::pair(kPanelInk, 2.0)}) {
    canvas_.line(left, right, color, width);
    canvas_.line(left - tick, left + tick, color, width);
    canvas_.line(right - tick, right + tick, color, width);
  }
  const std::string text = length_m >= 1000 ? fmt::format("{:g} km", length_m / 1000)
                           : length_m < 1   ? fmt::format("{:g} cm", 100 * length_m)
                                            : fmt::format("{:g} m", length_m);
  canvas_.text(text, (left + right) / 2 - Eigen::Vector2d(0, 14), 16, kPanelInk, true, 0.5, true);
}

void Panel::drawFrameOf(const Eigen::AlignedBox2d& area) {
  const Canvas::Point a = toPixel(Eigen::Vector2d(area.min())),
                      b = toPixel(Eigen::Vector2d(area.max()));
  canvas_.frame({a.cwiseMin(b), a.cwiseMax(b)}, kPanelInk, 1.6);
}

}  // namespace xview
