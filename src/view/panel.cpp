// SPDX-License-Identifier: BSD-3-Clause
#include "panel.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace xview {
namespace {

constexpr int kShift = 4;           // OpenCV's fixed-point coordinates: 1/16 pixel
constexpr double kFarOff_px = 1e5;  // beyond this OpenCV's fixed-point numbers overflow

cv::Point fixedPoint(const Eigen::Vector2d& p) {
  const double unit = 1 << kShift;
  return {cvRound(std::clamp(p.x(), -kFarOff_px, kFarOff_px) * unit),
          cvRound(std::clamp(p.y(), -kFarOff_px, kFarOff_px) * unit)};
}

Eigen::AlignedBox2d inShapeOf(const cv::Mat& pixels, const Eigen::AlignedBox2d& area) {
  const double aspect = static_cast<double>(pixels.cols) / pixels.rows;
  Eigen::Vector2d half = area.sizes() / 2;
  half = half.cwiseMax(1e-3);
  if (half.x() < aspect * half.y()) {
    half.x() = aspect * half.y();
  } else {
    half.y() = half.x() / aspect;
  }
  return {area.center() - half, area.center() + half};
}

int fontOf(bool bold) { return bold ? cv::FONT_HERSHEY_DUPLEX : cv::FONT_HERSHEY_SIMPLEX; }
double fontScale(double size_px) {
  return size_px / 30;
}  // Hershey letters are about 30 pixels from ascender to descender

std::string asciiOnly(const std::string& text) {
  std::string ascii;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0) == 0x80) continue;  // rest of a character that was replaced
    ascii += byte >= 32 && byte < 127 ? c : '?';
  }
  return ascii;
}

}  // namespace

Panel::Panel(cv::Mat pixels, const Eigen::AlignedBox2d& area)
    : pixels_(std::move(pixels)),
      area_(inShapeOf(pixels_, area)),
      scale_(pixels_.cols / area_.sizes().x()) {}

Eigen::Vector2d Panel::toPixel(const Eigen::Vector2d& p) const {
  return {(p.x() - area_.min().x()) * scale_, (area_.max().y() - p.y()) * scale_};
}

void Panel::fillSquare(const Eigen::Vector2d& center, double side_px, const Color& color) {
  const Eigen::Vector2d p = toPixel(center);
  const double half = side_px / 2;
  const int x0 = std::max(0, cvFloor(p.x() - half + 0.5)),
            x1 = std::min(pixels_.cols, std::max(x0 + 1, cvFloor(p.x() + half + 0.5)));
  const int y0 = std::max(0, cvFloor(p.y() - half + 0.5)),
            y1 = std::min(pixels_.rows, std::max(y0 + 1, cvFloor(p.y() + half + 0.5)));
  const cv::Vec3b value(color[2], color[1], color[0]);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) pixels_.at<cv::Vec3b>(y, x) = value;
  }
}

void Panel::line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Color& color,
                 int thickness) {
  if (!from.allFinite() || !to.allFinite()) return;
  cv::line(pixels_, fixedPoint(toPixel(from)), fixedPoint(toPixel(to)), bgr(color), thickness,
           cv::LINE_AA, kShift);
}

void Panel::polyline(const std::vector<Eigen::Vector2d>& points, const Color& color,
                     int thickness) {
  for (std::size_t i = 1; i < points.size(); ++i) line(points[i - 1], points[i], color, thickness);
}

void Panel::dashedPolyline(const std::vector<Eigen::Vector2d>& points, const Color& color,
                           int thickness, double dash_px) {
  const double dash_m = dash_px / scale_;
  double walked = 0;  // along the whole line, so that dashes go round corners
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d step = points[i] - points[i - 1];
    const double length = step.norm();
    if (!(length > 0) || length > 1e4 * dash_m) continue;
    for (double at = 0; at < length;) {
      const double left = dash_m - std::fmod(walked + at, dash_m),
                   end = std::min(length, at + std::max(left, 1e-6 * dash_m));
      if (static_cast<long long>((walked + at + 1e-9) / dash_m) % 2 == 0) {
        line(points[i - 1] + step * (at / length), points[i - 1] + step * (end / length), color,
             thickness);
      }
      at = end;
    }
    walked += length;
  }
}

void Panel::disc(const Eigen::Vector2d& center, double radius_px, const Color& fill,
                 const Color& rim) {
  const cv::Point at = fixedPoint(toPixel(center));
  const int radius = cvRound(radius_px * (1 << kShift));
  cv::circle(pixels_, at, radius, bgr(fill), cv::FILLED, cv::LINE_AA, kShift);
  if (radius_px > 2) cv::circle(pixels_, at, radius, bgr(rim), 1, cv::LINE_AA, kShift);
}

void Panel::ring(const Eigen::Vector2d& center, double radius_px, const Color& color,
                 int thickness) {
  cv::circle(pixels_, fixedPoint(toPixel(center)), cvRound(radius_px * (1 << kShift)), bgr(color),
             thickness, cv::LINE_AA, kShift);
}

std::vector<cv::Point> Panel::around(const Eigen::Vector2d& center,
                                     const std::vector<Eigen::Vector2d>& offsets_px) const {
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& offset : offsets_px)
    corners.push_back(fixedPoint(toPixel(center) + offset));
  return corners;
}

void Panel::polygon(const std::vector<cv::Point>& corners, const Color& fill, const Color& rim) {
  cv::fillConvexPoly(pixels_, corners, bgr(fill), cv::LINE_AA, kShift);
  cv::polylines(pixels_, corners, true, bgr(rim), 1, cv::LINE_AA, kShift);
}

void Panel::diamond(const Eigen::Vector2d& center, double radius_px, const Color& fill,
                    const Color& rim) {
  polygon(around(center, {{radius_px, 0}, {0, radius_px}, {-radius_px, 0}, {0, -radius_px}}), fill,
          rim);
}

void Panel::arrowHead(const Eigen::Vector2d& center, const Eigen::Vector2d& direction,
                      double radius_px, const Color& fill, const Color& rim, int rim_thickness) {
  const Eigen::Vector2d ahead =
      radius_px * Eigen::Vector2d(direction.x(), -direction.y()).normalized();
  const Eigen::Vector2d aside(-ahead.y(), ahead.x());
  const std::vector<cv::Point> corners = around(
      center, {ahead, -0.8 * ahead + 0.75 * aside, -0.4 * ahead, -0.8 * ahead - 0.75 * aside});
  cv::fillPoly(pixels_, std::vector<std::vector<cv::Point>>{corners}, bgr(fill), cv::LINE_AA,
               kShift);
  cv::polylines(pixels_, corners, true, bgr(rim), rim_thickness, cv::LINE_AA, kShift);
}

void writeText(cv::Mat& image, const std::string& text, const cv::Point& left, double size_px,
               const Color& color, bool bold) {
  const cv::Point origin(left.x, left.y + cvRound(size_px * 0.35));
  cv::putText(image, asciiOnly(text), origin, fontOf(bold), fontScale(size_px), bgr(color), 1,
              cv::LINE_AA);
}

int textWidth(const std::string& text, double size_px, bool bold) {
  int below = 0;
  return cv::getTextSize(asciiOnly(text), fontOf(bold), fontScale(size_px), 1, &below).width;
}

std::string fitted(const std::string& text, double size_px, int width_px, bool bold) {
  std::string shown = asciiOnly(text);
  if (textWidth(shown, size_px, bold) <= width_px) return shown;
  while (!shown.empty() && textWidth(shown + "...", size_px, bold) > width_px) shown.pop_back();
  return shown + "...";
}

}  // namespace xview
