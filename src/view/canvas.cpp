// SPDX-License-Identifier: BSD-3-Clause
#include "canvas.h"

#include <cairo-svg.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace xview {
namespace {

cairo_status_t appendBytes(void* bytes, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

/// Cairo stops for good at a text that is not UTF-8; what is not becomes U+FFFD, and a control
/// character a question mark.
std::string printable(const std::string& text) {
  using nlohmann::json;
  std::string shown = json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace))
                          .get<std::string>();
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  std::replace_if(shown.begin(), shown.end(), is_control, '?');
  return shown;
}

constexpr std::size_t kPngHead = 8 + 25;  // signature and header of a PNG

/// A chunk of UTF-8 text (PNG 1.2, 4.2.3.3), which `identify -verbose` and `exiftool` show.
std::string pngComment(const std::string& text) {
  const auto number = [](std::size_t value) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift & 0xFF);
    return bytes;
  };
  const std::string chunk = std::string("iTXtComment") + std::string(5, '\0') + text;
  return number(chunk.size() - 4) + chunk + number(libdeflate_crc32(0, chunk.data(), chunk.size()));
}

}  // namespace

Canvas::Canvas(double width, double height, PictureFormat format, std::string comment)
    : format_(format),
      comment_(std::move(comment)),
      surface_(format == PictureFormat::svg
                   ? cairo_svg_surface_create_for_stream(appendBytes, &bytes_, width, height)
                   : cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width),
                                                static_cast<int>(height)),
               cairo_surface_destroy),
      cairo_(cairo_create(surface_.get()), cairo_destroy) {
  cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  fill({Point(0, 0), Point(width, height)}, {255, 255, 255});
}

std::string Canvas::take() {
  if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("a picture cannot be drawn: ") +
                             cairo_status_to_string(cairo_status(cairo_.get())));
  if (format_ == PictureFormat::png)
    cairo_surface_write_to_png_stream(surface_.get(), appendBytes, &bytes_);
  if (format_ == PictureFormat::png && !comment_.empty())
    bytes_.insert(kPngHead, pngComment(comment_));
  cairo_surface_finish(surface_.get());
  return std::move(bytes_);
}

void Canvas::source(const Color& color, double opacity) {
  cairo_set_source_rgba(cairo_.get(), color[0] / 255.0, color[1] / 255.0, color[2] / 255.0,
                        opacity);
}

bool Canvas::trace(const std::vector<Point>& points) {
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

void Canvas::fill(const Eigen::AlignedBox2d& box, const Color& color, double opacity) {
  cairo_new_path(cairo_.get());
  cairo_rectangle(cairo_.get(), box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
  source(color, opacity);
  cairo_fill(cairo_.get());
}

void Canvas::frame(const Eigen::AlignedBox2d& box, const Color& color, double width) {
  const Point a = box.min(), b = box.max();
  polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, color, width);
}

void Canvas::polyline(const std::vector<Point>& points, const Color& color, double width,
                      double dash) {
  if (!trace(points)) return;
  source(color);
  cairo_set_line_width(cairo_.get(), width);
  cairo_set_dash(cairo_.get(), &dash, dash > 0 ? 1 : 0, 0);
  cairo_stroke(cairo_.get());
}

void Canvas::disc(const Point& center, double radius, const Color& fill, const Color& rim,
                  double rim_width) {
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

void Canvas::polygon(const std::vector<Point>& corners, const Color& fill, const Color& rim,
                     double rim_width) {
  if (!trace(corners)) return;
  cairo_close_path(cairo_.get());
  source(rim);
  cairo_set_line_width(cairo_.get(), 2 * rim_width);
  cairo_set_dash(cairo_.get(), nullptr, 0, 0);
  cairo_stroke_preserve(cairo_.get());
  source(fill);
  cairo_fill(cairo_.get());
}

void Canvas::font(double size, bool bold) {
  cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo_.get(), size);
}

double Canvas::textWidth(const std::string& text, double size, bool bold) {
  font(size, bold);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_.get(), printable(text).c_str(), &extents);
  return extents.x_advance;
}

void Canvas::text(const std::string& text, const Point& at, double size, const Color& color,
                  bool bold, double align, bool halo) {
  const std::string shown = printable(text);
  const double left = at.x() - align * textWidth(text, size, bold);
  cairo_move_to(cairo_.get(), left, at.y() + 0.36 * size);
  if (halo) {
    cairo_text_path(cairo_.get(), shown.c_str());
    source({255, 255, 255}, 0.85);
    cairo_set_line_width(cairo_.get(), 4);
    cairo_set_dash(cairo_.get(), nullptr, 0, 0);
    cairo_stroke(cairo_.get());
    cairo_move_to(cairo_.get(), left, at.y() + 0.36 * size);
  }
  source(color);
  cairo_show_text(cairo_.get(), shown.c_str());
}

std::string Canvas::fitted(const std::string& text, double size, double width, bool bold) {
  std::string shown = printable(text);
  if (textWidth(shown, size, bold) <= width) return shown;
  constexpr std::size_t kMost = 400;  // letters that fit into any width
  shown.resize(std::min(shown.size(), kMost));
  while (!shown.empty() && textWidth(shown + "…", size, bold) > width) {
    while (shown.size() > 1 && (static_cast<unsigned char>(shown.back()) & 0xC0) == 0x80)
      shown.pop_back();
    shown.pop_back();
  }
  return shown + "…";
}

void Canvas::image(const std::vector<std::uint32_t>& pixels, int width, const Point& corner) {
  if (pixels.empty() || width <= 0) return;
  auto* const bytes = reinterpret_cast<unsigned char*>(const_cast<std::uint32_t*>(pixels.data()));
  cairo_surface_t* const image = cairo_image_surface_create_for_data(
      bytes, CAIRO_FORMAT_ARGB32, width, static_cast<int>(pixels.size()) / width, 4 * width);
  cairo_set_source_surface(cairo_.get(), image, corner.x(), corner.y());
  cairo_paint(cairo_.get());
  cairo_set_source_rgb(cairo_.get(), 0, 0, 0);  // lets go of the image
  cairo_surface_destroy(image);
}

void Canvas::clip(const Eigen::AlignedBox2d& box) {
  cairo_save(cairo_.get());
  cairo_new_path(cairo_.get());
  cairo_rectangle(cairo_.get(), box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
  cairo_clip(cairo_.get());
}

void Canvas::unclip() { cairo_restore(cairo_.get()); }

}  // namespace xview
