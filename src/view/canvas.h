// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "drawing.h"
#include "painter.h"

namespace xview {

/// A picture of vectors and text, in pixels from the upper left corner.
class Canvas {
 public:
  using Point = Painter::Point;

  /// `comment`: kept in a PNG beside the picture.
  Canvas(double width, double height, PictureFormat format, std::string comment = "");
  /// The bytes of the file; nothing may be drawn afterwards.
  std::string take();

  void fill(const Eigen::AlignedBox2d& box, const Color& color, double opacity = 1) {
    painter_->fill(box, color, opacity);
  }
  void frame(const Eigen::AlignedBox2d& box, const Color& color, double width);
  void polyline(const std::vector<Point>& points, const Color& color, double width,
                double dash = 0) {
    painter_->polyline(points, color, width, dash);
  }
  void line(const Point& from, const Point& to, const Color& color, double width) {
    polyline({from, to}, color, width);
  }
  /// Filled, with a rim if its width is above 0. A hollow one has white inside.
  void disc(const Point& center, double radius, const Color& fill, const Color& rim,
            double rim_width) {
    painter_->disc(center, radius, fill, rim, rim_width);
  }
  void polygon(const std::vector<Point>& corners, const Color& fill, const Color& rim,
               double rim_width) {
    painter_->polygon(corners, fill, rim, rim_width);
  }
  /// A line of text, vertically centred at a point; align 0 begins there, 1 ends there. With a
  /// halo it is readable on anything.
  void text(const std::string& text, const Point& at, double size, const Color& color,
            bool bold = false, double align = 0, bool halo = false);
  double textWidth(const std::string& text, double size, bool bold = false);
  /// The beginning of a text that fits into a width, with an ellipsis if something is missing.
  std::string fitted(const std::string& text, double size, double width, bool bold = false);

  /// Nothing outside of the box is drawn from here to unclip().
  void clip(const Eigen::AlignedBox2d& box) { painter_->clip(box); }
  void unclip() { painter_->unclip(); }

  /// Pixels, row by row, as premultiplied ARGB.
  void image(const std::vector<std::uint32_t>& pixels, int width, const Point& corner) {
    painter_->image(pixels, width, corner);
  }

 private:
  PictureFormat format_;
  std::string comment_;
  std::unique_ptr<Painter> painter_;
};

}  // namespace xview
