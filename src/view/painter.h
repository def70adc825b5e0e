// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "drawing.h"

namespace xview {

/// What a Canvas is painted with: the part of it that cairo does, in the module xview_drawing.
/// Positions are pixels; texts are UTF-8 without control characters.
class Painter {
 public:
  using Point = Eigen::Vector2d;

  virtual ~Painter() = default;
  /// The bytes of the file; nothing may be drawn afterwards. Throws std::runtime_error.
  virtual std::string take() = 0;
  virtual void fill(const Eigen::AlignedBox2d& box, const Color& color, double opacity) = 0;
  virtual void polyline(const std::vector<Point>& points, const Color& color, double width,
                        double dash) = 0;
  virtual void disc(const Point& center, double radius, const Color& fill, const Color& rim,
                    double rim_width) = 0;
  virtual void polygon(const std::vector<Point>& corners, const Color& fill, const Color& rim,
                       double rim_width) = 0;
  /// `at`: where the line begins, on its base.
  virtual void text(const std::string& text, const Point& at, double size, const Color& color,
                    bool bold, bool halo) = 0;
  virtual double textWidth(const std::string& text, double size, bool bold) = 0;
  virtual void clip(const Eigen::AlignedBox2d& box) = 0;
  virtual void unclip() = 0;
  virtual void image(const std::vector<std::uint32_t>& pixels, int width, const Point& corner) = 0;
};

}  // namespace xview

/// The function of the module: a painter that is the caller's.
extern "C" xview::Painter* xviewPainter(double width, double height, xview::PictureFormat format);
