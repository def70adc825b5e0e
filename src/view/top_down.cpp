// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "panel.h"

namespace xview {
namespace {

// Pixels
constexpr int kWidth = 1600, kHeight = 1200, kMargin = 14, kTitle = 48, kLegend = 220;
constexpr int kLine = 2;         // thickness of lines that matter
constexpr double kLetters = 17;  // of the legend

constexpr double kSmallShare = 0.3;  // of the map, below which a query gets a panel of its own
constexpr double kFadeMap = 0.35, kFadeQuery = 0;

const LabelSet kNoLabels;

const LabelSet& labelsOf(const Scene& scene) {
  return scene.labels != nullptr ? *scene.labels : kNoLabels;
}

bool showsCloud(const Scene& scene) {
  return scene.map_cloud != nullptr && !scene.map_cloud->empty();
}
bool showsPlan(const Scene& scene) { return scene.map_plan != nullptr && !showsCloud(scene); }

// ---- what is where

void include(Eigen::AlignedBox2d& box, const Eigen::Vector3d& p) {
  if (p.allFinite()) box.extend(Eigen::Vector2d(p.head<2>()));
}

void include(Eigen::AlignedBox2d& box, const SemanticGraph* graph, const Eigen::Isometry3d& T) {
  if (graph == nullptr) return;
  for (const Vertex& v : graph->vertices) include(box, T * v.position);
}

void include(Eigen::AlignedBox2d& box, const std::vector<Eigen::Isometry3d>& poses,
             const Eigen::Isometry3d& T) {
  for (const Eigen::Isometry3d& pose : poses) include(box, T * pose.translation());
}

/// A few points that lie far off do not count.
void include(Eigen::AlignedBox2d& box, const LabelledCloud* cloud, const Eigen::Isometry3d& T) {
  constexpr double kOutliers = 0.002;
  std::vector<double> xs, ys;
  for (std::size_t i = 0; cloud != nullptr && i < cloud->size(); ++i) {
    const Eigen::Vector3d p = T * cloud->position(i);
    if (!p.allFinite()) continue;
    xs.push_back(p.x());
    ys.push_back(p.y());
  }
  if (xs.empty()) return;
  const auto ranked = [](std::vector<double>& values, std::size_t rank) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                     values.end());
    return values[rank];
  };
  const std::size_t last = xs.size() - 1;
  const auto low = static_cast<std::size_t>(kOutliers * static_cast<double>(last));
  for (const std::size_t rank : {low, last - low})
    box.extend(Eigen::Vector2d(ranked(xs, rank), ranked(ys, rank)));
}

Eigen::AlignedBox2d boxOf(const SceneQuery& query) {
  Eigen::AlignedBox2d box;
  include(box, query.graph, query.T_map_query);
  include(box, query.cloud, query.T_map_query);
  include(box, query.poses, query.T_map_query);
  include(box, query.true_poses, Eigen::Isometry3d::Identity());
  return box;
}

Eigen::AlignedBox2d mapBox(const Scene& scene) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox2d box;
  include(box, scene.map_graph, identity);
  include(box, scene.map_cloud, identity);
  include(box, scene.map_poses, identity);
  for (const SceneLine& line : scene.lines) {
    for (const Eigen::Vector3d& p : line.points) include(box, p);
  }
  if (scene.map_plan == nullptr) return box;
  const PlanView& plan = *scene.map_plan;
  for (const GroundCell& cell : plan.known) {
    include(box, {plan.origin_x + cell.x * plan.cell_m, plan.origin_y + cell.y * plan.cell_m, 0});
  }
  return box;
}

Eigen::AlignedBox2d withMargin(const Eigen::AlignedBox2d& box, double share) {
  if (box.isEmpty()) return {Eigen::Vector2d(-10, -10), Eigen::Vector2d(10, 10)};
  const Eigen::Vector2d margin =
      Eigen::Vector2d::Constant(std::max(2.0, share * box.sizes().maxCoeff()));
  return {box.min() - margin, box.max() + margin};
}

// ---- panels

void drawContent(Panel& panel, const Scene& scene) {
  const LabelSet& labels = labelsOf(scene);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  panel.pixels().setTo(cv::Scalar(252, 252, 252));
  drawGrid(panel);
  if (showsCloud(scene)) drawCloud(panel, *scene.map_cloud, labels, identity, kFadeMap);
  if (showsPlan(scene)) drawPlan(panel, *scene.map_plan);
  for (const SceneQuery& query : scene.queries) {
    if (query.cloud != nullptr)
      drawCloud(panel, *query.cloud, labels, query.T_map_query, kFadeQuery);
  }
  for (const SceneQuery& query : scene.queries) {
    if (scene.map_graph != nullptr) drawPutative(panel, query, *scene.map_graph);
  }
  if (scene.map_graph != nullptr) drawMapGraph(panel, *scene.map_graph, labels);
  drawKeyframes(panel, scene.map_poses);
  for (const SceneLine& line : scene.lines) {
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector3d& p : line.points) points.push_back(p.head<2>());
    panel.polyline(points, line.color, kLine);
  }
  for (const SceneQuery& query : scene.queries) {
    if (scene.map_graph != nullptr) drawKept(panel, query, *scene.map_graph);
    drawQueryGraph(panel, query, labels);
  }
  for (const SceneQuery& query : scene.queries) drawQueryPoses(panel, query);
  drawScaleBar(panel);
}

void drawBorder(cv::Mat pixels) {
  cv::rectangle(pixels, {0, 0}, {pixels.cols - 1, pixels.rows - 1}, cv::Scalar(190, 190, 190), 1);
}

/// A rectangle where the other panel looks.
void drawFrameOf(Panel& panel, const Eigen::AlignedBox2d& area) {
  const Eigen::Vector2d a = area.min(), b = area.max();
  panel.polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, {20, 20, 20}, kLine);
}

// ---- legend

/// A column of symbols with names.
class Legend {
 public:
  explicit Legend(cv::Mat pixels)
      : panel_(pixels, Eigen::AlignedBox2d(Eigen::Vector2d(0, 0),
                                           Eigen::Vector2d(pixels.cols, pixels.rows))) {}

  /// symbol(panel, centre) draws about 20 pixels wide. False if there is no room left.
  template <class Symbol>
  bool entry(const std::string& name, Symbol&& symbol) {
    if (next_ + kRow > panel_.height()) return false;
    const double y = next_ + kRow / 2;
    symbol(panel_, Eigen::Vector2d(18, panel_.height() - y));
    writeName(name, 38, y, {40, 40, 40});
    next_ += kRow;
    return true;
  }
  void more(std::size_t count) {
    writeName("and " + std::to_string(count) + " more", 6, next_ + kRow / 2, {110, 110, 110});
  }
  void gap() { next_ += kRow / 2; }
  /// Rows that are still free.
  std::size_t room() const {
    return static_cast<std::size_t>(std::max(0.0, (panel_.height() - next_) / kRow));
  }

 private:
  static constexpr double kRow = 26;
  void writeName(const std::string& name, double x, double y, const Color& color) {
    const std::string shown = fitted(name, kLetters, panel_.width() - cvRound(x));
    writeText(panel_.pixels(), shown, {cvRound(x), cvRound(y)}, kLetters, color);
  }

  Panel panel_;
  double next_ = 0;
};

void drawSymbols(Legend& legend, const Scene& scene) {
  const auto any = [&](auto&& has) {
    return std::any_of(scene.queries.begin(), scene.queries.end(), has);
  };
  const auto dash = [](const Color& color, int thickness) {
    return [color, thickness](Panel& p, const Eigen::Vector2d& at) {
      p.line(at - Eigen::Vector2d(12, 0), at + Eigen::Vector2d(12, 0), color, thickness);
    };
  };
  if (scene.map_graph != nullptr && !scene.map_graph->empty()) {
    legend.entry("map vertex", [&](Panel& p, const Eigen::Vector2d& at) {
      p.disc(at, 5, {190, 190, 190}, {40, 40, 40});
    });
  }
  if (!scene.map_poses.empty()) legend.entry("key frames", dash(kKeyframeColor, kLine));
  if (any([](const SceneQuery& q) { return q.graph != nullptr && !q.graph->empty(); })) {
    legend.entry("query vertex", [&](Panel& p, const Eigen::Vector2d& at) {
      p.diamond(at, 6, {190, 190, 190}, {40, 40, 40});
    });
  }
  if (any([](const SceneQuery& q) { return !q.putative.empty(); }))
    legend.entry("putative match", dash(kPutativeColor, 1));
  if (any([](const SceneQuery& q) { return !q.kept.empty(); })) {
    legend.entry("kept match",
                 [&](Panel& p, const Eigen::Vector2d& at) { p.ring(at, 8, kKeptColor, kLine); });
  }
  for (const Status status : {Status::accepted, Status::ambiguous, Status::rejected}) {
    if (any([&](const SceneQuery& q) { return !q.poses.empty() && q.status == status; })) {
      legend.entry(std::string("pose, ") + toString(status),
                   [&](Panel& p, const Eigen::Vector2d& at) {
                     p.arrowHead(at, {1, 0}, 11, statusColor(status), {255, 255, 255}, 1);
                   });
    }
  }
  if (any([](const SceneQuery& q) { return !q.true_poses.empty(); })) {
    legend.entry("true pose", [&](Panel& p, const Eigen::Vector2d& at) {
      p.arrowHead(at, {1, 0}, 11, {255, 255, 255}, kTruthColor, kLine);
    });
  }
  for (const SceneLine& line : scene.lines) {
    if (!line.name.empty()) legend.entry(line.name, dash(line.color, kLine));
  }
}

struct Swatch {
  std::string name;
  Color color;
};

std::vector<Swatch> swatchesOf(const Scene& scene) {
  std::vector<Swatch> swatches;
  const LabelSet& labels = labelsOf(scene);
  for (const std::uint32_t id : classesIn(scene)) {
    swatches.push_back({labels.className(id), labels.color(id)});
  }
  if (!showsPlan(scene)) return swatches;
  for (const Channel channel : drawnChannels()) {
    if ((*scene.map_plan)[channel].empty()) continue;
    std::string name = toString(channel);
    std::replace(name.begin(), name.end(), '_', ' ');
    swatches.push_back({name, channelColor(channel)});
  }
  return swatches;
}

void drawClasses(Legend& legend, const Scene& scene) {
  const std::vector<Swatch> swatches = swatchesOf(scene);
  const std::size_t room = legend.room();
  const std::size_t shown =
      swatches.size() <= room ? swatches.size() : std::max<std::size_t>(room, 1) - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    legend.entry(swatches[i].name, [&](Panel& p, const Eigen::Vector2d& at) {
      p.fillSquare(at, 16, swatches[i].color);
    });
  }
  if (shown < swatches.size()) legend.more(swatches.size() - shown);
}

void drawTitle(cv::Mat pixels, const std::string& title) {
  double size = 28;
  while (size > 16 && textWidth(title, size, true) > pixels.cols) size -= 1;
  writeText(pixels, fitted(title, size, pixels.cols, true), {0, pixels.rows / 2}, size,
            {30, 30, 30}, true);
}

/// The query's box if it is small in the map.
std::optional<Eigen::AlignedBox2d> smallQuery(const Scene& scene,
                                              const Eigen::AlignedBox2d& everything) {
  Eigen::AlignedBox2d box;
  for (const SceneQuery& query : scene.queries) box.extend(boxOf(query));
  if (box.isEmpty() || box.sizes().maxCoeff() > kSmallShare * everything.sizes().maxCoeff())
    return std::nullopt;
  const Eigen::Vector2d least =
      Eigen::Vector2d::Constant(10);  // metres around a query without extent
  return Eigen::AlignedBox2d(box.center() - least.cwiseMax(box.sizes() / 2),
                             box.center() + least.cwiseMax(box.sizes() / 2));
}

void drawPanels(cv::Mat pixels, const Scene& scene) {
  Eigen::AlignedBox2d everything = mapBox(scene);
  for (const SceneQuery& query : scene.queries) everything.extend(boxOf(query));
  const auto small = smallQuery(scene, everything);
  if (!small) {
    Panel panel(pixels, withMargin(everything, 0.03));
    drawContent(panel, scene);
    return drawBorder(pixels);
  }
  const int split = cvRound(0.4 * pixels.cols), gap = 8;
  cv::Mat left = pixels.colRange(0, split), right = pixels.colRange(split + gap, pixels.cols);
  Panel overview(left, withMargin(everything, 0.03)), close(right, withMargin(*small, 0.12));
  drawContent(overview, scene);
  drawFrameOf(overview, close.area());
  drawContent(close, scene);
  drawBorder(left);
  drawBorder(right);
}

}  // namespace

std::vector<std::uint8_t> drawTopDown(const Scene& scene) {
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(255, 255, 255));
  const auto part = [&](int x0, int y0, int x1, int y1) {
    return image(cv::Range(y0, y1), cv::Range(x0, x1));
  };
  constexpr int kLegendX = kWidth - kLegend;
  drawTitle(part(kMargin, 0, kWidth - kMargin, kTitle), scene.title);
  drawPanels(part(kMargin, kTitle, kLegendX - kMargin, kHeight - kMargin), scene);
  Legend legend(part(kLegendX, kTitle, kWidth - kMargin / 2, kHeight - kMargin));
  drawSymbols(legend, scene);
  legend.gap();
  drawClasses(legend, scene);

  std::vector<std::uint8_t> png;
  cv::imencode(".png", image, png);
  return png;
}

}  // namespace xview
