// SPDX-License-Identifier: BSD-3-Clause
#include "canvas.h"

#include <libdeflate.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "process/module.h"

namespace xview {
namespace {

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

Painter* newPainter(double width, double height, PictureFormat format) {
  // Cairo brings many libraries along, which no answer needs.
  const auto make = reinterpret_cast<decltype(&xviewPainter)>(
      moduleFunction("xview_drawing", "xviewPainter", "pictures"));
  return make(width, height, format);
}

}  // namespace

Canvas::Canvas(double width, double height, PictureFormat format, std::string comment)
    : format_(format), comment_(std::move(comment)), painter_(newPainter(width, height, format)) {
  fill({Point(0, 0), Point(width, height)}, {255, 255, 255});
}

std::string Canvas::take() {
  std::string bytes = painter_->take();
  if (format_ == PictureFormat::png && !comment_.empty())
    bytes.insert(kPngHead, pngComment(comment_));
  return bytes;
}

void Canvas::frame(const Eigen::AlignedBox2d& box, const Color& color, double width) {
  const Point a = box.min(), b = box.max();
  polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, color, width);
}

double Canvas::textWidth(const std::string& text, double size, bool bold) {
  return painter_->textWidth(printable(text), size, bold);
}

void Canvas::text(const std::string& text, const Point& at, double size, const Color& color,
                  bool bold, double align, bool halo) {
  const double left = at.x() - align * textWidth(text, size, bold);
  painter_->text(printable(text), {left, at.y() + 0.36 * size}, size, color, bold, halo);
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

}  // namespace xview
