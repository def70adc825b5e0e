// SPDX-License-Identifier: BSD-3-Clause
// The module xview_drawing.
#include <cairo-svg.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "painter.h"

namespace xview {
namespace {

cairo_status_t appendBytes(void* bytes, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

class CairoPainter final : public Painter {
 public:
  CairoPainter(double width, double height, PictureFormat format)
      : format_(format),
        surface_(format == PictureFormat::svg
                     ? cairo_svg_surface_create_for_stream(appendBytes, &bytes_, width, height)
                     : cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width),
                                                  static_cast<int>(height)),
                 cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  }

  std::string take() override {
    if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS)
      throw std::runtime_error(std::string("a picture cannot be drawn: ") +
                               cairo_status_to_string(cairo_status(cairo_.get())));
    if (format_ == PictureFormat::png)
      cairo_surface_write_to_png_stream(surface_.get(), appendBytes, &bytes_);
    cairo_surface_finish(surface_.get());
    return std::move(bytes_);
  }

  void fill(const Eigen::AlignedBox2d& box, const Color& color, double opacity) override {
    cairo_new_path(cairo_.get());
    cairo_rectangle(cairo_.get(), box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
    source(color, opacity);
    cairo_fill(cairo_.get());
  }

  void polyline(const std::vector<Point>& points, const Color& color, double width,
                double dash) override {
    if (!trace(points)) return;
    source(color);
    cairo_set_line_width(cairo_.get(), width);
    cairo_set_dash(cairo_.get(), &dash, dash > 0 ? 1 : 0, 0);
    cairo_stroke(cairo_.get());
  }

  void disc(const Point& center, double radius, const Color& fill, const Color& rim,
            double rim_width) override {
    if (!center.allFinite()) return;
    cairo_new_path(cairo_.get());
    cairo_arc(cairo_.get(), center.x(), center.y(), radius, 0, 2 * M_PI);
    source(fill);
    cairo_fill_preserve(cairo_.get());
    if (rim_width > 0) {
      source(rim);
      cairo_set_line_width(cairo_.get(), rim_width);
      cairo_set_dash(cairo_.get(), nullptr, 0, 0);
      cairo_stroke(cairo_.get());
    }
  }

  void polygon(const std::vector<Point>& corners, const Color& fill, const Color& rim,
               double rim_width) override {
    if (!trace(corners)) return;
    cairo_close_path(cairo_.get());
    source(rim);
    cairo_set_line_width(cairo_.get(), 2 * rim_width);
    cairo_set_dash(cairo_.get(), nullptr, 0, 0);
    cairo_stroke_preserve(cairo_.get());
    source(fill);
    cairo_fill(cairo_.get());
  }

  double textWidth(const std::string& text, double size, bool bold) override {
    font(size, bold);
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_.get(), text.c_str(), &extents);
    return extents.x_advance;
  }

  void text(const std::string& text, const Point& at, double size, const Color& color, bool bold,
            bool halo) override {
    font(size, bold);
    cairo_move_to(cairo_.get(), at.x(), at.y());
    if (halo) {
      cairo_text_path(cairo_.get(), text.c_str());
      source({255, 255, 255}, 0.85);
      cairo_set_line_width(cairo_.get(), 4);
      cairo_set_dash(cairo_.get(), nullptr, 0, 0);
      cairo_stroke(cairo_.get());
      cairo_move_to(cairo_.get(), at.x(), at.y());
    }
    source(color);
    cairo_show_text(cairo_.get(), text.c_str());
  }

  void image(const std::vector<std::uint32_t>& pixels, int width, const Point& corner) override {
    if (pixels.empty() || width <= 0) return;
    auto* const bytes = reinterpret_cast<unsigned char*>(const_cast<std::uint32_t*>(pixels.data()));
    cairo_surface_t* const image = cairo_image_surface_create_for_data(
        bytes, CAIRO_FORMAT_ARGB32, width, static_cast<int>(pixels.size()) / width, 4 * width);
    cairo_set_source_surface(cairo_.get(), image, corner.x(), corner.y());
    cairo_paint(cairo_.get());
    cairo_set_source_rgb(cairo_.get(), 0, 0, 0);  // lets go of the image
    cairo_surface_destroy(image);
  }

  void clip(const Eigen::AlignedBox2d& box) override {
    cairo_save(cairo_.get());
    cairo_new_path(cairo_.get());
    cairo_rectangle(cairo_.get(), box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
    cairo_clip(cairo_.get());
  }

  void unclip() override { cairo_restore(cairo_.get()); }

 private:
  void source(const Color& color, double opacity = 1) {
    cairo_set_source_rgba(cairo_.get(), color[0] / 255.0, color[1] / 255.0, color[2] / 255.0,
                          opacity);
  }

  bool trace(const std::vector<Point>& points) {
    constexpr double kFarOff = 1e6;  // cairo's fixed-point numbers overflow beyond 2^23
    cairo_new_path(cairo_.get());
    bool any = false;
    for (const Point& p : points) {
      if (!p.allFinite()) return false;
      cairo_line_to(cairo_.get(), std::clamp(p.x(), -kFarOff, kFarOff),
                    std::clamp(p.y(), -kFarOff, kFarOff));
      any = true;
    }
    return any;
  }

  void font(double size, bool bold) {
    cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_.get(), size);
  }

  std::string bytes_;  // of an SVG, while it grows
  PictureFormat format_;
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo_;
};

}  // namespace
}  // namespace xview

xview::Painter* xviewPainter(double width, double height, xview::PictureFormat format) {
  return new xview::CairoPainter(width, height, format);
}
