// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/plane_curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr int kSpan = 10;             ///< parts of the image width between the depths compared
constexpr int kEvery = 4;             ///< rows and columns looked at
constexpr std::size_t kFewest = 200;  ///< samples of a frame
constexpr std::size_t kFrames = 5;    ///< looked at, spread over the recording
constexpr double kLeastShift =
    0.004;  ///< what the two kinds must differ in; less means a narrow camera
constexpr double kBent =
    0.7;  ///< of that: bent as given; right data has 0.2 at most, wrong data 0.8 to 1.2
constexpr double kFlat = 0.3;  ///< of that: flat otherwise

struct Pixel {
  int u, v;
};

/// Inverse depths of a frame under both readings.
class InverseDepths {
 public:
  explicit InverseDepths(const Frame& frame) : frame_(frame) {}

  bool isMeasured(Pixel p) const {
    const float z = frame_.depth.at(p.u, p.v);
    return z > 0 && z < 1e9f;
  }
  /// Of planar depth, if the numbers are `range` along the ray, or are planar.
  double at(Pixel p, bool range) const {
    const Camera& c = frame_.camera;
    const double x = (p.u - c.cx) / c.fx, y = (p.v - c.cy) / c.fy;
    return (range ? std::sqrt(x * x + y * y + 1) : 1) / frame_.depth.at(p.u, p.v);
  }
  /// Second difference over three pixels in a line, as a share of the middle.
  double bend(const std::array<Pixel, 3>& line, bool range) const {
    return (at(line[0], range) + at(line[2], range)) / (2 * at(line[1], range)) - 1;
  }

 private:
  const Frame& frame_;
};

bool isOneFlatThing(const Frame& frame, const LabelSet& labels, const std::array<Pixel, 3>& line) {
  const std::uint16_t label = frame.label.at(line[1].u, line[1].v);
  const Kind kind = labels.kind(label);
  return (isGround(kind) || kind == Kind::building) &&
         frame.label.at(line[0].u, line[0].v) == label &&
         frame.label.at(line[2].u, line[2].v) == label;
}

}  // namespace

std::optional<PlaneCurvature> curvatureOfPlanes(const Frame& frame, const LabelSet& labels) {
  const InverseDepths inverse(frame);
  const int span = std::max(1, frame.depth.width / kSpan);
  std::vector<double> as_given, otherwise;
  const auto look = [&](const std::array<Pixel, 3>& line) {
    const auto measured = [&](Pixel p) { return inverse.isMeasured(p); };
    if (!isOneFlatThing(frame, labels, line) || !std::all_of(line.begin(), line.end(), measured))
      return;
    as_given.push_back(inverse.bend(line, frame.camera.depth_is_range));
    otherwise.push_back(inverse.bend(line, !frame.camera.depth_is_range));
  };
  for (int v = 0; v < frame.depth.height; v += kEvery) {
    for (int u = 0; u < frame.depth.width; u += kEvery) {
      if (u >= span && u + span < frame.depth.width)
        look({Pixel{u - span, v}, {u, v}, {u + span, v}});
      if (v >= span && v + span < frame.depth.height)
        look({Pixel{u, v - span}, {u, v}, {u, v + span}});
    }
  }
  if (as_given.size() < kFewest) return std::nullopt;
  return PlaneCurvature{medianOf(as_given), medianOf(otherwise)};
}

bool planesSayOtherKind(const FrameSource& source) {
  std::vector<double> as_given, otherwise;
  for (std::size_t i = 0; i < std::min(kFrames, source.size()); ++i) {
    const auto curvature = curvatureOfPlanes(
        source.read(source.size() <= kFrames ? i : i * source.size() / kFrames), source.labels());
    if (!curvature) continue;
    as_given.push_back(curvature->as_given);
    otherwise.push_back(curvature->otherwise);
  }
  if (as_given.empty()) return false;
  const double given = medianOf(as_given), other = medianOf(otherwise),
               shift = std::abs(given - other);
  return shift >= kLeastShift && std::abs(given) > kBent * shift && std::abs(other) < kFlat * shift;
}

}  // namespace xview
