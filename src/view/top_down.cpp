// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "base/in_order.h"
#include "base/median.h"
#include "panel.h"

namespace xview {
namespace {

// Pixels
constexpr double kLongest = 1600, kHighest = 1200, kLeastWidth = 1000, kLeastHeight = 420;
constexpr double kMargin = 22, kGap = 10, kTitleSize = 28, kTextSize = 15, kRow = 25;
constexpr Color kInk{34, 36, 42}, kFaint{104, 108, 118}, kRule{206, 208, 214};

constexpr double kSmallShare = 0.3;  // of the map, below which a query gets a panel of its own

bool showsCloud(const Scene& scene) { return scene.map_cloud && !scene.map_cloud->empty(); }
bool showsBev(const Scene& scene) { return scene.map_bev && !showsCloud(scene); }

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

/// A few points that lie far off do not count: those farther outside of all others than a tenth of
/// what those fill.
void include(Eigen::AlignedBox2d& box, const LabelledCloud* cloud, const Eigen::Isometry3d& T) {
  constexpr double kOutliers = 0.002, kAround = 0.1;
  std::vector<double> xs, ys;
  for (std::size_t i = 0; cloud != nullptr && i < cloud->size(); ++i) {
    const Eigen::Vector3d p = T * cloud->position(i);
    if (!p.allFinite()) continue;
    xs.push_back(p.x());
    ys.push_back(p.y());
  }
  if (xs.empty()) return;
  const std::size_t last = xs.size() - 1;
  const auto low = static_cast<std::size_t>(kOutliers * static_cast<double>(last));
  const auto boxFrom = [&](std::size_t rank) {
    return Eigen::AlignedBox2d(
        Eigen::Vector2d(rankedOf(xs, rank), rankedOf(ys, rank)),
        Eigen::Vector2d(rankedOf(xs, last - rank), rankedOf(ys, last - rank)));
  };
  const Eigen::AlignedBox2d most = boxFrom(low);
  const Eigen::Vector2d around = Eigen::Vector2d::Constant(kAround * most.sizes().maxCoeff());
  box.extend(boxFrom(0).intersection({most.min() - around, most.max() + around}));
}

Eigen::AlignedBox2d boxOf(const SceneQuery& query) {
  Eigen::AlignedBox2d box;
  if (!query.has_pose) return box;
  include(box, query.graph, query.T_map_query);
  include(box, query.cloud, query.T_map_query);
  include(box, query.poses, query.T_map_query);
  include(box, query.true_poses, Eigen::Isometry3d::Identity());
  for (const SceneMark& mark : query.marks) include(box, mark.at);
  return box;
}

Eigen::AlignedBox2d mapBox(const Scene& scene) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox2d box;
  include(box, scene.map_graph, identity);
  include(box, scene.map_cloud, identity);
  if (box.isEmpty()) include(box, scene.map_poses, identity);
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(box.isEmpty() ? 0 : box.sizes().norm());
  const Eigen::AlignedBox2d around(box.min() - reach, box.max() + reach);
  for (const Eigen::Isometry3d& pose : scene.map_poses) {  // a cloud has one at its origin
    if (around.contains(Eigen::Vector2d(pose.translation().head<2>())))
      include(box, pose.translation());
  }
  for (const SceneMark& mark : scene.marks) include(box, mark.at);
  for (const SceneLine& line : scene.lines) {
    for (const Eigen::Vector3d& p : line.points) include(box, p);
  }
  if (scene.map_bev == nullptr) return box;
  const BevGrid& bev = *scene.map_bev;
  for (const GroundCell& cell : bev.known)
    include(box, {bev.origin_x + cell.x * bev.cell_m, bev.origin_y + cell.y * bev.cell_m, 0});
  return box;
}

Eigen::AlignedBox2d withMargin(const Eigen::AlignedBox2d& box, double share) {
  if (box.isEmpty()) return {Eigen::Vector2d(-10, -10), Eigen::Vector2d(10, 10)};
  const double longest = box.sizes().maxCoeff();
  const Eigen::Vector2d margin =
      Eigen::Vector2d::Constant(longest > 0 ? share * longest : 2);  // of a single point
  return {box.min() - margin, box.max() + margin};
}

/// The queries' box if it is small in the map.
std::optional<Eigen::AlignedBox2d> smallQuery(const Scene& scene,
                                              const Eigen::AlignedBox2d& everything) {
  Eigen::AlignedBox2d box;
  for (const SceneQuery& query : scene.queries) box.extend(boxOf(query));
  if (box.isEmpty() || box.sizes().maxCoeff() > kSmallShare * everything.sizes().maxCoeff())
    return std::nullopt;
  const double least_m = 0.02 * everything.sizes().maxCoeff();  // around a query without extent
  const Eigen::Vector2d half = (box.sizes() / 2).cwiseMax(least_m);
  return Eigen::AlignedBox2d(box.center() - half, box.center() + half);
}

// ---- panels

void drawContent(Canvas& canvas, const Eigen::AlignedBox2d& box, Panel& panel, const Scene& scene,
                 const Eigen::AlignedBox2d* frame_of) {
  const LabelSet& labels = labelsOf(scene);
  canvas.clip(box);
  panel.drawGrid();
  if (showsCloud(scene)) panel.drawCloud(*scene.map_cloud, labels);
  if (showsBev(scene)) panel.drawBev(*scene.map_bev);
  panel.drawQueryClouds(scene.queries, labels);
  if (scene.map_graph != nullptr)
    panel.drawMapGraph(*scene.map_graph, labels, showsCloud(scene) || showsBev(scene));
  panel.drawKeyframes(scene.map_poses);
  for (const SceneLine& line : scene.lines) panel.drawLine(line);
  panel.drawMarks(scene.marks);
  for (const SceneQuery& query : scene.queries) {
    if (query.has_pose) panel.drawWay(query);
  }
  for (const SceneQuery& query : scene.queries) {
    if (query.has_pose && scene.map_graph != nullptr)
      panel.drawMatches(query, *scene.map_graph, labels);
    panel.drawMarks(query.marks);
  }
  const double size = scene.queries.size() > 40 ? 9 : 14;
  for (const SceneQuery& query : scene.queries) {
    if (query.has_pose) panel.drawArrow(query, size);
  }
  for (std::size_t i = 0; areNumbered(scene.queries) && i < scene.queries.size(); ++i) {
    if (scene.queries[i].has_pose) panel.drawNumber(scene.queries[i], i + 1, size);
  }
  if (frame_of) panel.drawFrameOf(*frame_of);
  panel.drawCoordinates();
  panel.drawScaleBar();
  canvas.unclip();
  canvas.frame(box, kRule, 1);
}

// ---- legend

using Symbol = std::function<void(Canvas&, const Canvas::Point&)>;
struct LegendEntry {
  std::string name;
  Symbol draw;
  double x = 0;  // from the left end of the legend
  int row = 0;
};

Symbol dashOf(const Color& color, double width) {
  return [=](Canvas& canvas, const Canvas::Point& at) {
    canvas.line(at - Eigen::Vector2d(9, 0), at + Eigen::Vector2d(9, 0), color, width);
  };
}
Symbol swatchOf(const Color& color) {
  return [=](Canvas& canvas, const Canvas::Point& at) {
    const Eigen::AlignedBox2d box(at - Eigen::Vector2d(7, 7), at + Eigen::Vector2d(7, 7));
    canvas.fill(box, color);
    canvas.frame(box, kRule, 0.8);
  };
}
Symbol dotOf(const Color& color) {
  return [=](Canvas& canvas, const Canvas::Point& at) {
    canvas.disc(at, 4, color, {255, 255, 255}, 0.6);
  };
}
Symbol arrowOf(const Color& fill, const Color& rim) {
  return [=](Canvas& canvas, const Canvas::Point& at) {
    drawArrowHead(canvas, at, {1, 0}, 9, fill, rim);
  };
}
Symbol diamondOf(bool filled) {
  return [=](Canvas& canvas, const Canvas::Point& at) { drawDiamond(canvas, at, 5.5, filled); };
}

void addOnce(std::vector<LegendEntry>& entries, const std::string& name, Symbol symbol) {
  const auto same = [&](const LegendEntry& e) { return e.name == name; };
  if (!name.empty() && std::none_of(entries.begin(), entries.end(), same))
    entries.push_back({name, std::move(symbol)});
}

std::vector<LegendEntry> queryEntries(const Scene& scene) {
  std::vector<LegendEntry> entries;
  for (const Status status : {Status::accepted, Status::ambiguous, Status::rejected}) {
    for (const SceneQuery& query : scene.queries) {
      if (query.status == status && query.has_pose && !query.poses.empty())
        addOnce(entries, std::string("pose, ") + toString(status),
                arrowOf(statusColor(status), {255, 255, 255}));
    }
  }
  for (std::size_t i = 0; i < scene.queries.size(); ++i) {
    const SceneQuery& query = scene.queries[i];
    if (!query.true_poses.empty())
      addOnce(entries, "true pose", arrowOf({255, 255, 255}, kTruthColor));
    if (query.cloud)
      addOnce(entries,
              areNumbered(scene.queries)
                  ? std::to_string(i + 1) + " " + query.name.substr(query.name.rfind('/') + 1)
                  : "query",
              swatchOf(queryColor(scene.queries, i)));
    if (query.graph && !query.graph->empty()) {
      if (!query.kept.empty()) addOnce(entries, "vertex, kept", diamondOf(true));
      addOnce(entries, "vertex without partner", diamondOf(false));
    }
    for (const SceneMark& mark : query.marks) addOnce(entries, mark.group, dotOf(mark.color));
  }
  for (const SceneMark& mark : scene.marks) addOnce(entries, mark.group, dotOf(mark.color));
  for (const SceneLine& line : scene.lines) addOnce(entries, line.name, dashOf(line.color, 2));
  if (scene.map_poses.size() > 1) addOnce(entries, "key frames", dashOf(kKeyframeColor, 1.4));
  return entries;
}

/// Classes of one colour are one entry.
std::vector<LegendEntry> mapEntries(const Scene& scene) {
  const LabelSet& labels = labelsOf(scene);
  const bool bare_graph = !showsCloud(scene) && !showsBev(scene);
  std::vector<std::pair<Color, std::string>> names;
  const auto add = [&](const Color& color, const std::string& name) {
    std::string& of_color = valueOf(names, color);
    if (of_color.find(name) == std::string::npos) of_color += (of_color.empty() ? "" : ", ") + name;
  };
  if (!showsBev(scene)) {
    for (const std::uint32_t id : classesIn(scene))
      add(bare_graph ? Color(labels.color(id)) : quietColor(labels, id),
          labels.className(id) + (!bare_graph && isCeiling(labels, id) ? " (not drawn)" : ""));
  } else {
    for (const auto& [channel, name, color] : drawnBevChannels(*scene.map_bev)) add(color, name);
  }
  std::vector<LegendEntry> entries;
  for (const auto& [color, name] : names) entries.push_back({name, swatchOf(color)});
  return entries;
}

/// Entries in rows as wide as the picture.
class Legend {
 public:
  Legend(Canvas& canvas, const Scene& scene, double width) {
    for (const auto& entries : {queryEntries(scene), mapEntries(scene)}) {
      if (!entries_.empty() && !entries.empty()) breakRow();
      for (const LegendEntry& entry : entries) place(canvas, entry, width);
    }
    if (left_out_ > 0) entries_.back().name = "and " + std::to_string(left_out_ + 1) + " more";
  }
  double height() const { return entries_.empty() ? 0 : (row_ + 1) * kRow + 8; }

  void draw(Canvas& canvas, const Canvas::Point& corner) const {
    for (const LegendEntry& entry : entries_) {
      const Canvas::Point at = corner + Eigen::Vector2d(entry.x, (entry.row + 0.5) * kRow);
      entry.draw(canvas, at + Eigen::Vector2d(9, 0));
      canvas.text(entry.name, at + Eigen::Vector2d(25, 0), kTextSize, kInk);
    }
  }

 private:
  static constexpr int kMostRows = 6;

  void breakRow() {
    x_ = 0;
    ++row_;
  }
  void place(Canvas& canvas, LegendEntry entry, double width) {
    if (left_out_ > 0) return void(++left_out_);
    entry.name = canvas.fitted(entry.name, kTextSize, 320);
    const double needed = 25 + canvas.textWidth(entry.name, kTextSize) + 24;
    if (x_ > 0 && x_ + needed > width) {
      if (row_ + 1 >= kMostRows) return void(++left_out_);
      breakRow();
    }
    entry.x = x_;
    entry.row = row_;
    x_ += needed;
    entries_.push_back(std::move(entry));
  }

  std::vector<LegendEntry> entries_;
  double x_ = 0;
  int row_ = 0;
  std::size_t left_out_ = 0;
};

// ---- layout

/// What each panel shows: everything, or an overview and what is close.
struct Layout {
  double width = kLongest, height = kHighest;  // of the panels
  Eigen::AlignedBox2d everything;
  std::optional<Eigen::AlignedBox2d> close;
};

Layout layoutOf(const Scene& scene) {
  Layout layout;
  Eigen::AlignedBox2d box = mapBox(scene);
  for (const SceneQuery& query : scene.queries) box.extend(boxOf(query));
  layout.close = smallQuery(scene, box);
  layout.everything = withMargin(box, 0.025);
  if (layout.close) {
    layout.close = withMargin(*layout.close, 0.1);
    layout.height = 800;
    return layout;
  }
  const Eigen::Vector2d size = layout.everything.sizes();
  const double scale = std::min(kLongest / size.x(), kHighest / size.y());
  layout.width = std::clamp(std::round(scale * size.x()), kLeastWidth, kLongest);
  layout.height = std::clamp(std::round(scale * size.y()), kLeastHeight, kHighest);
  return layout;
}

void drawPanels(Canvas& canvas, const Canvas::Point& corner, const Layout& layout,
                const Scene& scene) {
  const Canvas::Point end = corner + Eigen::Vector2d(layout.width, layout.height);
  if (!layout.close) {
    const Eigen::AlignedBox2d box(corner, end);
    Panel panel(canvas, box, layout.everything);
    return drawContent(canvas, box, panel, scene, nullptr);
  }
  const Eigen::Vector2d sizes = layout.everything.sizes();
  const double share = std::clamp(layout.height * sizes.x() / sizes.y() / layout.width, 0.25, 0.5);
  const double split = std::round(corner.x() + share * layout.width);
  const Eigen::AlignedBox2d left(corner, Canvas::Point(split, end.y())),
      right(Canvas::Point(split + kGap, corner.y()), end);
  Panel overview(canvas, left, layout.everything), close(canvas, right, *layout.close);
  drawContent(canvas, left, overview, scene, &close.area());
  drawContent(canvas, right, close, scene, nullptr);
}

double headHeight(const Scene& scene) {
  return (scene.title.empty() ? 0 : 48) + (scene.caption.empty() ? 0 : 24) +
         (scene.title.empty() && scene.caption.empty() ? kMargin : 8);
}

void drawHead(Canvas& canvas, const Scene& scene, double width) {
  double y = 34;
  if (!scene.title.empty()) {
    canvas.text(canvas.fitted(scene.title, kTitleSize, width, true), {kMargin, y}, kTitleSize, kInk,
                true);
    y += 31;
  }
  if (!scene.caption.empty())
    canvas.text(canvas.fitted(scene.caption, kTextSize, width), {kMargin, y}, kTextSize, kFaint);
}

}  // namespace

std::string drawTopDown(const Scene& scene, PictureFormat format) {
  const Layout layout = layoutOf(scene);
  Canvas ruler(1, 1, PictureFormat::png);
  const Legend legend(ruler, scene, layout.width);
  const double head = headHeight(scene), foot = std::max(kMargin, legend.height() + kGap);
  Canvas canvas(layout.width + 2 * kMargin, head + layout.height + foot, format, scene.made_by);
  drawHead(canvas, scene, layout.width);
  drawPanels(canvas, {kMargin, head}, layout, scene);
  legend.draw(canvas, {kMargin, head + layout.height + kGap});
  return canvas.take();
}

}  // namespace xview
