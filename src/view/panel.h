// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "canvas.h"

namespace xview {

/// A part of a picture that shows a rectangle of the map frame from above: x to the right, y up,
/// one scale. Its functions are the layers of a picture, in the order in which they are drawn.
class Panel {
 public:
  /// `area` is enlarged to the shape of the box.
  Panel(Canvas& canvas, const Eigen::AlignedBox2d& box, const Eigen::AlignedBox2d& area);

  const Eigen::AlignedBox2d& area() const { return area_; }

  void drawGrid();
  void drawBev(const BevGrid& bev);
  /// The highest point of a place is seen.
  void drawCloud(const LabelledCloud& cloud, const LabelSet& labels);
  void drawQueryClouds(const std::vector<SceneQuery>& queries, const LabelSet& labels);
  /// Without surfaces and edges it leaves a cloud below it visible.
  void drawMapGraph(const SemanticGraph& graph, const LabelSet& labels, bool objects_only);
  void drawKeyframes(const std::vector<Eigen::Isometry3d>& poses);
  void drawLine(const SceneLine& line);
  void drawMatches(const SceneQuery& query, const SemanticGraph& map, const LabelSet& labels);
  void drawMarks(const std::vector<SceneMark>& marks);
  void drawWay(const SceneQuery& query);
  void drawArrow(const SceneQuery& query, double size);
  /// Beside the arrow.
  void drawNumber(const SceneQuery& query, std::size_t number, double size);
  void drawScaleBar();
  /// A rectangle where another panel looks.
  void drawFrameOf(const Eigen::AlignedBox2d& area);
  void drawCoordinates();

 private:
  bool shows(const Eigen::Vector3d& p) const;
  Canvas::Point toPixel(const Eigen::Vector2d& p) const;
  Canvas::Point toPixel(const Eigen::Vector3d& p) const {
    return toPixel(Eigen::Vector2d(p.head<2>()));
  }
  std::vector<Canvas::Point> toPixels(const std::vector<Eigen::Vector3d>& points) const;
  template <class ColorOf>
  void splat(const LabelledCloud& cloud, const Eigen::Isometry3d& T, double size_m,
             ColorOf&& argbOf, std::vector<std::uint32_t>& pixels) const;
  double gridStep() const;

  Canvas& canvas_;
  Eigen::AlignedBox2d box_, area_;
  double scale_ = 1;  // pixels per metre
};

/// An arrow head around a point, its tip towards a direction on the picture; a disc if that is
/// zero.
void drawArrowHead(Canvas& canvas, const Canvas::Point& at, const Eigen::Vector2d& direction,
                   double size, const Color& fill, const Color& rim);

/// The sign of a vertex of a query: filled if it was kept.
void drawDiamond(Canvas& canvas, const Canvas::Point& at, double radius, bool filled);

}  // namespace xview
