// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "drawing.h"

namespace xview {

/// OpenCV keeps blue first.
inline cv::Scalar bgr(const Color& c) { return cv::Scalar(c[2], c[1], c[0]); }

/// A part of a picture that shows a rectangle of the map frame from above: x to the right, y up,
/// one scale.
class Panel {
 public:
  /// `area` is enlarged to the shape of the pixels.
  Panel(cv::Mat pixels, const Eigen::AlignedBox2d& area);

  const Eigen::AlignedBox2d& area() const { return area_; }
  double pixelsPerMetre() const { return scale_; }
  int width() const { return pixels_.cols; }
  int height() const { return pixels_.rows; }
  cv::Mat& pixels() { return pixels_; }
  bool shows(const Eigen::Vector2d& p) const { return area_.contains(p); }
  /// In pixels from the upper left corner.
  Eigen::Vector2d toPixel(const Eigen::Vector2d& p) const;

  void fillSquare(const Eigen::Vector2d& center, double side_px, const Color& color);
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Color& color,
            int thickness = 1);
  void polyline(const std::vector<Eigen::Vector2d>& points, const Color& color, int thickness = 1);
  void dashedPolyline(const std::vector<Eigen::Vector2d>& points, const Color& color, int thickness,
                      double dash_px);
  void disc(const Eigen::Vector2d& center, double radius_px, const Color& fill, const Color& rim);
  void ring(const Eigen::Vector2d& center, double radius_px, const Color& color, int thickness);
  void diamond(const Eigen::Vector2d& center, double radius_px, const Color& fill,
               const Color& rim);
  /// An arrow head around a point, its tip towards a direction of the map frame.
  void arrowHead(const Eigen::Vector2d& center, const Eigen::Vector2d& direction, double radius_px,
                 const Color& fill, const Color& rim, int rim_thickness);

 private:
  std::vector<cv::Point> around(const Eigen::Vector2d& center,
                                const std::vector<Eigen::Vector2d>& offsets_px) const;
  void polygon(const std::vector<cv::Point>& corners, const Color& fill, const Color& rim);

  cv::Mat pixels_;
  Eigen::AlignedBox2d area_;
  double scale_ = 1;
};

/// Text with its left end at a pixel, vertically centred. What is not ASCII becomes '?'.
void writeText(cv::Mat& image, const std::string& text, const cv::Point& left, double size_px,
               const Color& color, bool bold = false);

/// Width of a text in pixels.
int textWidth(const std::string& text, double size_px, bool bold = false);

/// The beginning of a text that fits into a width, with "..." if something is missing.
std::string fitted(const std::string& text, double size_px, int width_px, bool bold = false);

// Layers of a picture from above, in the order in which they are drawn.

void drawGrid(Panel& panel);
void drawPlan(Panel& panel, const PlanView& plan);
/// The highest point of a place is seen. `fade` mixes white into the colours, more into the ground.
void drawCloud(Panel& panel, const LabelledCloud& cloud, const LabelSet& labels,
               const Eigen::Isometry3d& T_map_cloud, double fade);
void drawMapGraph(Panel& panel, const SemanticGraph& graph, const LabelSet& labels);
void drawKeyframes(Panel& panel, const std::vector<Eigen::Isometry3d>& poses);
void drawPutative(Panel& panel, const SceneQuery& query, const SemanticGraph& map);
void drawKept(Panel& panel, const SceneQuery& query, const SemanticGraph& map);
void drawQueryGraph(Panel& panel, const SceneQuery& query, const LabelSet& labels);
void drawQueryPoses(Panel& panel, const SceneQuery& query);
void drawScaleBar(Panel& panel);

}  // namespace xview
