// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/top_down.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "panel.h"
#include "top_down_layers.h"
#include "xview/types/error.h"

namespace xview {
namespace {

constexpr double kSmallShare =
    0.3;  // of the map's size, below which a query gets a panel of its own
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
// -------------------------------------------------------------------------------------------------------

/// A box around points; a few that lie far off do not count if there are many.
class Extent {
 public:
  void add(const Eigen::Vector3d& p) {
    if (!p.allFinite()) return;
    xs_.push_back(p.x());
    ys_.push_back(p.y());
  }
  Eigen::AlignedBox2d box(double outliers = 0) {
    Eigen::AlignedBox2d result;
    if (xs_.empty()) return result;
    const auto last = static_cast<double>(xs_.size() - 1);
    const auto low = static_cast<std::ptrdiff_t>(std::floor(outliers * last)),
               high = static_cast<std::ptrdiff_t>(last) - low;
    result.extend(Eigen::Vector2d(ranked(xs_, low), ranked(ys_, low)));
    result.extend(Eigen::Vector2d(ranked(xs_, high), ranked(ys_, high)));
    return result;
  }

 private:
  static double ranked(std::vector<double>& values, std::ptrdiff_t rank) {
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
  }
  std::vector<double> xs_, ys_;
};

Eigen::AlignedBox2d boxOf(const LabelledCloud* cloud, const Eigen::Isometry3d& T) {
  Extent extent;
  for (std::size_t i = 0; cloud != nullptr && i < cloud->size(); ++i)
    extent.add(T * cloud->position(i));
  return extent.box(0.002);
}

Eigen::AlignedBox2d boxOf(const SemanticGraph* graph, const Eigen::Isometry3d& T) {
  Extent extent;
  if (graph != nullptr) {
    for (const Vertex& v : graph->vertices) extent.add(T * v.position);
  }
  return extent.box();
}

Eigen::AlignedBox2d boxOf(const std::vector<Eigen::Isometry3d>& poses, const Eigen::Isometry3d& T) {
  Extent extent;
  for (const Eigen::Isometry3d& pose : poses) extent.add(T * pose.translation());
  return extent.box();
}

Eigen::AlignedBox2d boxOf(const PlanView* plan) {
  Extent extent;
  if (plan != nullptr) {
    for (const GroundCell& cell : plan->known) {
      extent.add(
          {plan->origin_x + cell.x * plan->cell_m, plan->origin_y + cell.y * plan->cell_m, 0});
    }
  }
  return extent.box();
}

Eigen::AlignedBox2d boxOf(const SceneQuery& query) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox2d box = boxOf(query.graph, query.T_map_query);
  box.extend(boxOf(query.cloud, query.T_map_query));
  box.extend(boxOf(query.poses, query.T_map_query));
  return box.merged(boxOf(query.true_poses, identity));
}

Eigen::AlignedBox2d mapBox(const Scene& scene) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox2d box = boxOf(scene.map_graph, identity);
  box.extend(boxOf(scene.map_cloud, identity));
  box.extend(boxOf(scene.map_poses, identity));
  for (const SceneLine& line : scene.lines) {
    Extent extent;
    for (const Eigen::Vector3d& p : line.points) extent.add(p);
    box.extend(extent.box());
  }
  return box.merged(boxOf(scene.map_plan));
}

Eigen::AlignedBox2d withMargin(const Eigen::AlignedBox2d& box, double share) {
  if (box.isEmpty()) return {Eigen::Vector2d(-10, -10), Eigen::Vector2d(10, 10)};
  const Eigen::Vector2d margin =
      Eigen::Vector2d::Constant(std::max(2.0, share * box.sizes().maxCoeff()));
  return {box.min() - margin, box.max() + margin};
}

// ---- panels
// --------------------------------------------------------------------------------------------------------------

void drawContent(Panel& panel, const Scene& scene, double unit_px) {
  const LabelSet& labels = labelsOf(scene);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  panel.pixels().setTo(cv::Scalar(252, 252, 252));
  drawGrid(panel, unit_px);
  if (showsCloud(scene)) drawCloud(panel, *scene.map_cloud, labels, identity, kFadeMap);
  if (showsPlan(scene)) drawPlan(panel, *scene.map_plan);
  for (const SceneQuery& query : scene.queries) {
    if (query.cloud != nullptr)
      drawCloud(panel, *query.cloud, labels, query.T_map_query, kFadeQuery);
  }
  for (const SceneQuery& query : scene.queries) {
    if (scene.map_graph != nullptr) drawPutative(panel, query, *scene.map_graph);
  }
  if (scene.map_graph != nullptr) drawMapGraph(panel, *scene.map_graph, labels, unit_px);
  drawKeyframes(panel, scene.map_poses, unit_px);
  for (const SceneLine& line : scene.lines) {
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector3d& p : line.points) points.push_back(p.head<2>());
    panel.polyline(points, line.color, std::max(1, cvRound(2 * unit_px)));
  }
  for (const SceneQuery& query : scene.queries) {
    if (scene.map_graph != nullptr) drawKept(panel, query, *scene.map_graph, unit_px);
    drawQueryGraph(panel, query, labels, unit_px);
  }
  for (const SceneQuery& query : scene.queries) drawQueryPoses(panel, query, unit_px);
  drawScaleBar(panel, unit_px);
}

void drawBorder(cv::Mat pixels) {
  cv::rectangle(pixels, {0, 0}, {pixels.cols - 1, pixels.rows - 1}, cv::Scalar(190, 190, 190), 1);
}

/// A rectangle where the other panel looks.
void drawFrameOf(Panel& panel, const Eigen::AlignedBox2d& area, double unit_px) {
  const Eigen::Vector2d a = area.min(), b = area.max();
  panel.polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, {20, 20, 20},
                 std::max(1, cvRound(2 * unit_px)));
}

// ---- legend
// --------------------------------------------------------------------------------------------------------------

/// A column of symbols with names.
class Legend {
 public:
  Legend(cv::Mat pixels, double unit_px)
      : panel_(pixels, Eigen::AlignedBox2d(Eigen::Vector2d(0, 0),
                                           Eigen::Vector2d(pixels.cols, pixels.rows))),
        unit_(unit_px) {}

  /// symbol(panel, centre) draws about 20 pixels wide. False if there is no room left.
  template <class Symbol>
  bool entry(const std::string& name, Symbol&& symbol) {
    if (next_ + kRow * unit_ > panel_.height()) return false;
    const double y = next_ + kRow * unit_ / 2;
    symbol(panel_, Eigen::Vector2d(18 * unit_, panel_.height() - y));
    writeName(name, 38 * unit_, y, {40, 40, 40});
    next_ += kRow * unit_;
    return true;
  }
  void more(std::size_t count) {
    writeName("and " + std::to_string(count) + " more", 6 * unit_, next_ + kRow * unit_ / 2,
              {110, 110, 110});
  }
  void gap() { next_ += kRow * unit_ / 2; }
  /// Rows that are still free.
  std::size_t room() const {
    return static_cast<std::size_t>(std::max(0.0, (panel_.height() - next_) / (kRow * unit_)));
  }

 private:
  static constexpr double kRow = 26;
  void writeName(const std::string& name, double x, double y, const Color& color) {
    const std::string shown = fitted(name, 17 * unit_, panel_.width() - cvRound(x));
    writeText(panel_.pixels(), shown, {cvRound(x), cvRound(y)}, 17 * unit_, color);
  }

  Panel panel_;
  double unit_;
  double next_ = 0;
};

void drawSymbols(Legend& legend, const Scene& scene, double unit) {
  const auto any = [&](auto&& has) {
    return std::any_of(scene.queries.begin(), scene.queries.end(), has);
  };
  const auto dash = [unit](const Color& color, int thickness) {
    return [unit, color, thickness](Panel& p, const Eigen::Vector2d& at) {
      p.line(at - Eigen::Vector2d(12 * unit, 0), at + Eigen::Vector2d(12 * unit, 0), color,
             thickness);
    };
  };
  const int thick = std::max(1, cvRound(2 * unit));
  if (scene.map_graph != nullptr && !scene.map_graph->empty()) {
    legend.entry("map vertex", [&](Panel& p, const Eigen::Vector2d& at) {
      p.disc(at, 5 * unit, {190, 190, 190}, {40, 40, 40});
    });
  }
  if (!scene.map_poses.empty()) legend.entry("key frames", dash(kKeyframeColor, thick));
  if (any([](const SceneQuery& q) { return q.graph != nullptr && !q.graph->empty(); })) {
    legend.entry("query vertex", [&](Panel& p, const Eigen::Vector2d& at) {
      p.diamond(at, 6 * unit, {190, 190, 190}, {40, 40, 40});
    });
  }
  if (any([](const SceneQuery& q) { return !q.putative.empty(); }))
    legend.entry("putative match", dash(kPutativeColor, 1));
  if (any([](const SceneQuery& q) { return !q.kept.empty(); })) {
    legend.entry("kept match", [&](Panel& p, const Eigen::Vector2d& at) {
      p.ring(at, 8 * unit, kKeptColor, thick);
    });
  }
  for (const Status status : {Status::accepted, Status::ambiguous, Status::rejected}) {
    if (any([&](const SceneQuery& q) { return !q.poses.empty() && q.status == status; })) {
      legend.entry(std::string("pose, ") + toString(status),
                   [&](Panel& p, const Eigen::Vector2d& at) {
                     p.arrowHead(at, {1, 0}, 11 * unit, statusColor(status), {255, 255, 255}, 1);
                   });
    }
  }
  if (any([](const SceneQuery& q) { return !q.true_poses.empty(); })) {
    legend.entry("true pose", [&](Panel& p, const Eigen::Vector2d& at) {
      p.arrowHead(at, {1, 0}, 11 * unit, {255, 255, 255}, kTruthColor, thick);
    });
  }
  for (const SceneLine& line : scene.lines) {
    if (!line.name.empty()) legend.entry(line.name, dash(line.color, thick));
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

void drawClasses(Legend& legend, const Scene& scene, double unit) {
  const std::vector<Swatch> swatches = swatchesOf(scene);
  const std::size_t room = legend.room();
  const std::size_t shown =
      swatches.size() <= room ? swatches.size() : std::max<std::size_t>(room, 1) - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    legend.entry(swatches[i].name, [&](Panel& p, const Eigen::Vector2d& at) {
      p.fillSquare(at, 16 * unit, swatches[i].color);
    });
  }
  if (shown < swatches.size()) legend.more(swatches.size() - shown);
}

void drawTitle(cv::Mat pixels, const std::string& title, double unit) {
  double size = 28 * unit;
  while (size > 16 * unit && textWidth(title, size, true) > pixels.cols) size -= unit;
  writeText(pixels, fitted(title, size, pixels.cols, true), {0, pixels.rows / 2}, size,
            {30, 30, 30}, true);
}

void requireSize(const TopDownOptions& options) {
  if (options.width < 320 || options.width > 16000 || options.height < 240 ||
      options.height > 16000) {
    throw UsageError("size of the picture is " + std::to_string(options.width) + " x " +
                     std::to_string(options.height) + ", must be 320 x 240 to 16000 x 16000");
  }
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

void drawPanels(cv::Mat pixels, const Scene& scene, bool zoom, double unit) {
  Eigen::AlignedBox2d everything = mapBox(scene);
  for (const SceneQuery& query : scene.queries) everything.extend(boxOf(query));
  const auto small = zoom ? smallQuery(scene, everything) : std::nullopt;
  if (!small) {
    Panel panel(pixels, withMargin(everything, 0.03));
    drawContent(panel, scene, unit);
    return drawBorder(pixels);
  }
  const int split = cvRound(0.4 * pixels.cols), gap = cvRound(8 * unit);
  cv::Mat left = pixels.colRange(0, split), right = pixels.colRange(split + gap, pixels.cols);
  Panel overview(left, withMargin(everything, 0.03)), close(right, withMargin(*small, 0.12));
  drawContent(overview, scene, unit);
  drawFrameOf(overview, close.area(), unit);
  drawContent(close, scene, unit);
  drawBorder(left);
  drawBorder(right);
}

}  // namespace

std::vector<std::uint8_t> drawTopDown(const Scene& scene, const TopDownOptions& options) {
  requireSize(options);
  const double unit = std::min(options.height / 1200.0, options.width / 1600.0);
  const int margin = cvRound(14 * unit), title = cvRound(48 * unit),
            legend_width = cvRound(220 * unit);
  cv::Mat image(options.height, options.width, CV_8UC3, cv::Scalar(255, 255, 255));
  const auto part = [&](int x0, int y0, int x1, int y1) {
    return image(cv::Range(y0, y1), cv::Range(x0, x1));
  };

  drawTitle(part(margin, 0, options.width - margin, title), scene.title, unit);
  const int legend_x = options.width - legend_width;
  drawPanels(part(margin, title, legend_x - margin, options.height - margin), scene, options.zoom,
             unit);
  Legend legend(part(legend_x, title, options.width - margin / 2, options.height - margin), unit);
  drawSymbols(legend, scene, unit);
  legend.gap();
  drawClasses(legend, scene, unit);

  std::vector<std::uint8_t> png;
  cv::imencode(".png", image, png);
  return png;
}

}  // namespace xview
