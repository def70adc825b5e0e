// SPDX-License-Identifier: BSD-3-Clause
// Charts as SVG, in colours that can be read on white and on black: the page holds the same ones as
// the files beside it.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "view/scene.h"

namespace xview {
namespace {

constexpr double kWidth = 310, kHeight = 240, kLeft = 36, kRight = 22, kTop = 44, kBottom = 44;
constexpr const char* kGrey = "#808790";
constexpr const char* kColors[] = {"#3f7de0", "#27a05a", "#d68200"};

std::string textAt(double x, double y, const std::string& said, const char* anchor,
                   const char* more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" {}>{}</text>\n", x, y,
                     anchor, more, xmlText(said));
}

std::string lineFrom(double x1, double y1, double x2, double y2) {
  return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" opacity=\".4\"/>\n",
                     x1, y1, x2, y2, kGrey);
}

double logOdds(double p) { return std::log10(p / (1 - p)); }

/// A value to its place on the x axis; what is beyond its ends lies on them.
class Axis {
 public:
  explicit Axis(const SceneChart& chart) : kind_(chart.axis) {
    if (kind_ == ChartAxis::share) ticks_ = {0, 0.25, 0.5, 0.75, 1};
    if (kind_ == ChartAxis::odds) ticks_ = {0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999};
    if (kind_ == ChartAxis::length) setDecades(chart);
    low_ = on(ticks_.front()), high_ = on(ticks_.back());
    if (kind_ == ChartAxis::odds) low_ -= 0.4, high_ += 0.4;
  }
  double operator()(double value) const {
    const double at = std::clamp((on(value) - low_) / std::max(1e-9, high_ - low_), 0.0, 1.0);
    return kLeft + (kWidth - kLeft - kRight) * at;
  }
  const std::vector<double>& ticks() const { return ticks_; }
  std::string label(double tick) const {
    if (kind_ == ChartAxis::share) return fmt::format("{}", 100 * tick);
    if (kind_ == ChartAxis::odds) return fmt::format("{}", tick);
    return tick < 0.0095  ? fmt::format("{:g} mm", 1e3 * tick)
           : tick < 0.995 ? fmt::format("{:g} cm", 1e2 * tick)
                          : fmt::format("{:g} m", tick);
  }

 private:
  double on(double value) const {
    switch (kind_) {
      case ChartAxis::length:
        return std::log10(std::max(value, 1e-12));
      case ChartAxis::odds:
        return logOdds(std::clamp(value, 1e-6, 1 - 1e-6));
      case ChartAxis::share:
        break;
    }
    return value;
  }
  void setDecades(const SceneChart& chart) {
    double low = 1, high = 1;
    for (const auto& [name, points] : chart.curves) {
      for (const Eigen::Vector2d& p : points) {
        if (p.x() > 0 && std::isfinite(p.x()))
          low = std::min(low, p.x()), high = std::max(high, p.x());
      }
    }
    const int first = static_cast<int>(std::floor(std::log10(low) + 1e-9));
    const int last = static_cast<int>(std::ceil(std::log10(high) - 1e-9));
    for (int e = first; e <= std::max(last, first + 1); ++e) ticks_.push_back(std::pow(10, e));
  }

  ChartAxis kind_;
  std::vector<double> ticks_;
  double low_ = 0, high_ = 1;
};

double yOf(double share) { return kHeight - kBottom - (kHeight - kBottom - kTop) * share; }

std::string frameOf(const SceneChart& chart, const Axis& x) {
  std::string svg = textAt(4, 15, chart.title, "start", "font-size=\"13\" font-weight=\"600\"") +
                    textAt(4, 34, chart.y_name + " [%]", "start");
  for (const int percent : {0, 25, 50, 75, 100}) {
    const double y = yOf(percent / 100.0);
    svg += lineFrom(kLeft, y, kWidth - kRight, y) +
           textAt(kLeft - 6, y + 4, std::to_string(percent), "end");
  }
  for (const double tick : x.ticks())
    svg += lineFrom(x(tick), kTop, x(tick), kHeight - kBottom) +
           textAt(x(tick), kHeight - kBottom + 16, x.label(tick), "middle");
  return svg + textAt((kLeft + kWidth - kRight) / 2, kHeight - 8,
                      chart.x_name + (chart.axis == ChartAxis::share ? " [%]" : ""), "middle");
}

std::string polyline(const std::vector<Eigen::Vector2d>& points, const Axis& x, const char* color,
                     const char* more) {
  std::string path;
  for (const Eigen::Vector2d& p : points) {
    if (p.allFinite()) path += fmt::format("{:.1f},{:.1f} ", x(p.x()), yOf(p.y()));
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" {}/>\n", path, color,
                     more);
}

/// What is claimed as a dashed line, what came true as dots with their numbers.
std::string reliability(const SceneChart& chart, const Axis& x) {
  std::vector<Eigen::Vector2d> claimed;
  for (double odds = -3.4; odds <= 3.41; odds += 0.1) {
    const double p = 1 / (1 + std::pow(10, -odds));
    claimed.emplace_back(p, p);
  }
  std::string svg = polyline(claimed, x, kGrey, "stroke-width=\"2\" stroke-dasharray=\"5 4\"");
  for (const auto& [name, points] : chart.curves) {
    for (const Eigen::Vector2d& p : points) {
      if (!p.allFinite()) continue;
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"{}\"/>\n", x(p.x()),
                         yOf(p.y()), kColors[0]);
      const bool above = p.y() < 0.5;  // what is written stays between the axes
      svg += textAt(x(p.x()), yOf(p.y()) + (above ? -10 : 20), name, "middle");
    }
  }
  return svg;
}

}  // namespace

std::string xmlText(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return safe;
}

std::string chartSvg(const SceneChart& chart) {
  const Axis x(chart);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\" fill=\"{2}\">\n{3}",
      kWidth, kHeight, kGrey, frameOf(chart, x));
  if (chart.axis == ChartAxis::odds) return svg + reliability(chart, x) + "</svg>\n";
  for (std::size_t i = 0; i < chart.curves.size(); ++i) {
    const char* const color = kColors[i % std::size(kColors)];
    const bool hides = i + 1 < chart.curves.size();  // so that equal curves are both seen
    svg += polyline(chart.curves[i].second, x, color,
                    hides ? "stroke-width=\"5\"" : "stroke-width=\"2\"");
    if (chart.curves.size() > 1)
      svg += textAt(kWidth - kRight - 6,
                    kHeight - kBottom - 10 - 16.0 * double(chart.curves.size() - 1 - i),
                    chart.curves[i].first, "end", fmt::format("style=\"fill:{}\"", color).c_str());
  }
  return svg + "</svg>\n";
}

}  // namespace xview
