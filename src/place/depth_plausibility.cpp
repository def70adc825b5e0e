// SPDX-License-Identifier: BSD-3-Clause
#include "place/depth_plausibility.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/median.h"
#include "base/stray_points.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr int kSamplesAcross = 48;   ///< pixels compared per row and column
constexpr double kTolerance = 0.05;  ///< of two depths of one point
constexpr double kApart_m = 0.5;     ///< poses at least so far apart tell scales apart
constexpr std::size_t kMostFramesOn = 10;

/// Depth as a camera tells it.
double depthOf(const Camera& camera, const Eigen::Vector3d& p_sensor) {
  return camera.depth_is_range ? p_sensor.norm() : p_sensor.z();
}

/// Whether a frame measures a point about where it is: within the tolerance in one of 3x3 pixels,
/// as surfaces seen at a grazing angle change by more from pixel to pixel. None if the point is out
/// of view.
std::optional<bool> isMeasuredAt(const Frame& frame, const Eigen::Vector3d& p_sensor,
                                 double scale) {
  if (p_sensor.z() <= 0) return std::nullopt;
  const double u = frame.camera.fx * p_sensor.x() / p_sensor.z() + frame.camera.cx;
  const double v = frame.camera.fy * p_sensor.y() / p_sensor.z() + frame.camera.cy;
  if (!(u > 1 && v > 1 && u < frame.depth.width - 2 && v < frame.depth.height - 2))
    return std::nullopt;
  const double expected = depthOf(frame.camera, p_sensor);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const float z = frame.depth.at(static_cast<int>(std::lround(u)) + du,
                                     static_cast<int>(std::lround(v)) + dv);
      if (isDepth(z) && std::abs(expected / (scale * z) - 1) < kTolerance) return true;
    }
  }
  return false;
}

/// What becomes of the pixels of one frame in another one, if depths times a scale and the poses
/// are right.
struct DepthAgreement {
  double visible = 0;   ///< share of the pixels that the other frame should see
  double agreeing = 0;  ///< share of these that it measures there, within 5 %
};

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale) {
  const Eigen::Isometry3d T_b_a = b.T_odom_sensor.inverse() * a.T_odom_sensor;
  int compared = 0, visible = 0, agreeing = 0;
  const int step_u = std::max(1, a.depth.width / kSamplesAcross),
            step_v = std::max(1, a.depth.height / kSamplesAcross);
  for (int v = step_v / 2; v < a.depth.height; v += step_v) {
    for (int u = step_u / 2; u < a.depth.width; u += step_u) {
      const float depth = a.depth.at(u, v);
      if (!isDepth(depth)) continue;
      ++compared;
      const auto measured = isMeasuredAt(b, T_b_a * a.camera.unproject(u, v, scale * depth), scale);
      visible += measured.has_value();
      agreeing += measured.value_or(false);
    }
  }
  DepthAgreement result;
  if (compared > 0) result.visible = static_cast<double>(visible) / compared;
  if (visible > 0) result.agreeing = static_cast<double>(agreeing) / visible;
  return result;
}

using FramePair = std::pair<Frame, Frame>;

/// The next frame from another place that looks the same way; none if the camera turns before.
std::optional<std::size_t> firstThatMoved(const FrameSource& source, std::size_t a) {
  constexpr double kSameWay = 0.94;  // cosine of 20 degrees
  const Eigen::Isometry3d from = source.pose(a);
  for (std::size_t b = a + 1; b < std::min(source.size(), a + kMostFramesOn); ++b) {
    const Eigen::Isometry3d to = source.pose(b);
    if ((from.translation() - to.translation()).norm() < kApart_m) continue;
    if (from.linear().col(2).dot(to.linear().col(2)) >= kSameWay) return b;
    break;
  }
  return std::nullopt;
}

/// Frames of five places of a recording, or fewer, between which the camera has moved by half a
/// metre or more and hardly turned: what both see is then most of what they see.
std::vector<FramePair> movedPairs(const FrameSource& source) {
  constexpr std::size_t kLookedAt = 16, kMostPairs = 5;
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t i = 1; i < kLookedAt; ++i) {
    const std::size_t a = i * source.size() / kLookedAt;
    if (!found.empty() && found.back().first == a) continue;
    if (const auto b = firstThatMoved(source, a)) found.emplace_back(a, *b);
  }
  std::vector<FramePair> pairs;
  const FrameSource& measured = source.asMeasured();
  const std::size_t step = (found.size() + kMostPairs - 1) / kMostPairs;
  for (std::size_t i = 0; i < found.size(); i += step)
    pairs.emplace_back(measured.read(found[i].first), measured.read(found[i].second));
  return pairs;
}

DepthAgreement agreementOf(const std::vector<FramePair>& pairs, double scale) {
  DepthAgreement mean;
  for (const auto& [a, b] : pairs) {
    const DepthAgreement one = agreementOfDepths(a, b, scale);
    mean.visible += one.visible / static_cast<double>(pairs.size());
    mean.agreeing += one.agreeing / static_cast<double>(pairs.size());
  }
  return mean;
}

constexpr int kSpan = 10;             ///< parts of the image width between the depths compared
constexpr int kEvery = 4;             ///< rows and columns looked at
constexpr std::size_t kFewest = 200;  ///< samples of a frame
constexpr std::size_t kFrames = 5;    ///< looked at, spread over the recording
constexpr double kLeastShift =
    0.004;  ///< what the two kinds must differ in; less means a narrow camera
constexpr double kBent =
    0.7;  ///< of that: bent as given; right data has 0.2 at most, wrong data 0.8 to 1.2
constexpr double kFlatOtherwise = 0.3;  ///< of that: flat otherwise

struct Pixel {
  int u, v;
};

/// Inverse depths of a frame under both readings.
class InverseDepths {
 public:
  explicit InverseDepths(const Frame& frame) : frame_(frame) {}

  bool isMeasured(Pixel p) const { return isDepth(frame_.depth.at(p.u, p.v)); }
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

bool isOneFlatObject(const Frame& frame, const LabelSet& labels, const std::array<Pixel, 3>& line) {
  const std::uint16_t label = frame.label.at(line[1].u, line[1].v);
  const Kind kind = labels.kind(label);
  return (isGround(kind) || kind == Kind::building) &&
         frame.label.at(line[0].u, line[0].v) == label &&
         frame.label.at(line[2].u, line[2].v) == label;
}

/// How bent ground and houses look, 0 = flat. The inverse of planar depth is an affine function of
/// the pixel on every plane, so its second difference over a tenth of the image is zero, but for
/// noise and edges, which the median passes over. With depth along the ray taken for planar depth,
/// or the other way round, it is one or two percent of the inverse depth, all over a frame of 90
/// degrees.
struct PlaneCurvature {
  double as_given = 0;   ///< with depths as the camera declares them
  double otherwise = 0;  ///< with the other kind of depth
};

/// None if too little ground and houses are seen.
std::optional<PlaneCurvature> curvatureOfPlanes(const Frame& frame, const LabelSet& labels) {
  const InverseDepths inverse(frame);
  const int span = std::max(1, frame.depth.width / kSpan);
  std::vector<double> as_given, otherwise;
  const auto look = [&](const std::array<Pixel, 3>& line) {
    const auto measured = [&](Pixel p) { return inverse.isMeasured(p); };
    if (!isOneFlatObject(frame, labels, line) || !std::all_of(line.begin(), line.end(), measured))
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

/// Whether planes of a recording say that depths are of the other kind than its camera declares: as
/// given they are bent by what the two kinds differ in, otherwise they are flat. False if it cannot
/// be told.
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
  return shift >= kLeastShift && std::abs(given) > kBent * shift &&
         std::abs(other) < kFlatOtherwise * shift;
}

constexpr double kFewLifted =
    0.02;  ///< less of what was measured in range is no unusual recording any more
/// Half of a frame nearer than the one: a room, or a wrong scale; farther than the other: a flight,
/// or a wrong scale.
constexpr float kSmallRange_m = 5, kLargeRange_m = 20;
constexpr double kSeen = 0.05;  ///< share of pixels that both frames see
constexpr double kAgree = 0.7;  ///< share of these that agree if the scale is right: 0.85 to 1.00
                                ///< in towns, noisy ones included
constexpr double kBetter =
    0.003;  ///< more agreement for the other kind of depth: 0.006 to 0.5 in towns
constexpr double kContradict = 0.75;  ///< and if it is ten times too small, over that share: 0.1
                                      ///< to 0.5 near the ground, 0.7 from the air
/// And if it is ten times too large, over that share, where the motion is next to nothing: 0.67 to
/// 0.84 near the ground. Right ones agree better than a tenth of them anywhere.
constexpr double kContradictLarge = 0.88;

/// What to type if lengths have this unit.
std::string toMetres(double unit_m) { return howToMove(unit_m * Eigen::Matrix3d::Identity()); }

/// Of all that was measured, whatever its class and range [m].
float medianMeasured(const Frame& frame) {
  std::vector<float> values;
  for (const float z : frame.depth.pixels) {
    if (isDepth(z)) values.push_back(z);
  }
  for (const Point& p : frame.cloud.points) {
    if (p.getVector3fMap().allFinite()) values.push_back(p.getVector3fMap().norm());
  }
  return values.empty() ? 0 : medianOf(std::move(values));
}

/// How many times larger (or a tenth, ...) depths would have to be for frames to agree; none if
/// they agree as they are, or do not tell.
std::optional<double> missingFactor(const FrameSource& source) {
  if (source.sensor() != Sensor::camera) return std::nullopt;
  const std::vector<FramePair> pairs = movedPairs(source);
  const double as_given = agreementOf(pairs, 1).agreeing;
  double best = as_given;
  std::optional<double> factor;
  for (const double candidate : {10., 100., 1000., 0.1, 0.01, 0.001}) {
    const DepthAgreement agreement = agreementOf(pairs, candidate);
    if (agreement.visible < kSeen || agreement.agreeing <= best) continue;
    best = agreement.agreeing;
    factor = candidate;
  }
  if (!factor || best < kAgree) return std::nullopt;
  return as_given <= (*factor > 1 ? kContradict : kContradictLarge) * best ? factor : std::nullopt;
}

std::string scaleHint(const FrameSource& source, std::optional<double> factor) {
  const Frame frame = source.read(source.size() / 2);
  const float median_m = medianMeasured(frame);
  if (source.sensor() != Sensor::camera)
    return fmt::format("half of the points are beyond {:.4g} m; are their coordinates in metres?",
                       median_m);
  std::string hint = fmt::format("the median depth is {:.4g} m with depth_scale {:g}", median_m,
                                 frame.camera.depth_scale);
  if (!factor) return hint + "; is that scale right?";
  return hint + fmt::format("; is it depth_scale {:g}?", *factor * frame.camera.depth_scale);
}

void requireInRange(const LiftCounts& counts, const FrameSource& source) {
  const auto measured = static_cast<double>(counts.lifted + counts.out_of_range);
  if (measured == 0 || static_cast<double>(counts.lifted) >= kFewLifted * measured) return;
  throw Error(source.name(),
              fmt::format("{:.1f} % of the measurements are out of range (lift.min_range_m to "
                          "lift.max_range_m): {}",
                          100.0 * static_cast<double>(counts.out_of_range) / measured,
                          scaleHint(source, missingFactor(source))));
}

void requireScale(const FrameSource& source) {
  const auto factor = missingFactor(source);
  if (!factor) return;
  throw Error(
      source.name(),
      fmt::format("depths contradict the poses, but would agree with them if they were {:g} times "
                  "as large: {}",
                  *factor, scaleHint(source, factor)));
}

constexpr std::size_t kSampled = 100000;  ///< points of a cloud that tell where its points lie
constexpr double kTall_m = 30;            ///< places where z is up are seldom so high
constexpr double kNarrow = 1.0 / 3;       ///< and seldom narrower than that share of their height

/// How sparse things of this kind are in metres, and how steep a place is.
struct Unlikely {
  float height_m, steepness, spacing_m;
};

bool isUnlikely(const Eigen::AlignedBox3d& box, std::size_t things, const Unlikely& unlikely) {
  if (box.isEmpty()) return false;
  const Eigen::Vector3d size = box.sizes();
  const double area = size.prod() / size.minCoeff();
  return size.minCoeff() >= unlikely.height_m &&
         size.minCoeff() >= unlikely.steepness * size.maxCoeff() &&
         area >= std::pow(unlikely.spacing_m, 2) * static_cast<double>(things);
}

/// Where most of the points lie along an axis [m].
struct Extent {
  double low = 0, middle = 0, high = 0;
  double reach() const { return high - low; }
};

Extent extentAlong(const LabelledCloud& cloud, int axis) {
  std::vector<float> values;
  const std::size_t step = 1 + cloud.size() / kSampled;
  for (std::size_t i = 0; i < cloud.size(); i += step)
    values.push_back(cloud.points[i].getVector3fMap()[axis]);
  if (values.empty()) return {};
  return {quantileOf(values, 0.05), quantileOf(values, 0.5), quantileOf(values, 0.95)};
}

std::array<Extent, 3> extentsOf(const LabelledCloud& cloud) {
  return {extentAlong(cloud, 0), extentAlong(cloud, 1), extentAlong(cloud, 2)};
}

std::string sizesText(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d size = box.sizes();
  return fmt::format("{:.0f} x {:.0f} x {:.0f} m", size.x(), size.y(), size.z());
}

}  // namespace

/// Two witnesses that do not know of each other, because a refusal of right data is worse than a
/// map that is somewhat bent.
void requireKindOfDepth(const FrameSource& source) {
  if (source.sensor() != Sensor::camera || !planesSayOtherKind(source)) return;
  std::vector<FramePair> pairs = movedPairs(source);
  if (pairs.empty()) return;
  const bool is_range = pairs[0].first.camera.depth_is_range;
  const double as_given = agreementOf(pairs, 1).agreeing;
  for (FramePair& pair : pairs)
    pair.first.camera.depth_is_range = pair.second.camera.depth_is_range = !is_range;
  const double otherwise = agreementOf(pairs, 1).agreeing;
  if (otherwise < kAgree || otherwise < as_given + kBetter) return;
  throw Error(
      source.name(),
      fmt::format("ground and houses are curved, but would be flat if depths were {} instead of "
                  "{}; frames then agree in {:.1f} % "
                  "of what both see instead of {:.1f} %: is `depth: {}` missing in camera.yaml?",
                  is_range ? "along the optical axis" : "along the rays",
                  is_range ? "along the rays" : "along the optical axis", 100 * otherwise,
                  100 * as_given, is_range ? "planar" : "range"));
}

std::string howToMove(const Eigen::Matrix3d& linear) {
  std::string lines;
  for (int row = 0; row < 3; ++row)
    lines += fmt::format("`{:g} {:g} {:g} 0`, ", linear(row, 0), linear(row, 1), linear(row, 2));
  return "`xview lift IN OUT.pcd --transform FILE` makes it so with the lines " + lines +
         "`0 0 0 1` in FILE";
}

Eigen::Array3d middleReach(const LabelledCloud& cloud) {
  const auto [x, y, z] = extentsOf(cloud);
  return {x.reach(), y.reach(), z.reach()};
}

Eigen::Matrix3d turnUpright(int axis, int sign) {
  // A quarter turn about the other one of x and y.
  const double s = axis == 0 ? -sign : sign;
  const Eigen::AngleAxisd turn(s * M_PI / 2, Eigen::Vector3d::Unit(1 - axis));
  return turn.toRotationMatrix().array().round() + 0.0;  // no -0
}

namespace {

/// Longitude and latitude with a height in metres are as thin as nothing that stands.
void requireNoDegrees(const Eigen::AlignedBox3d& box, const std::string& name) {
  constexpr double kWidest = 0.05, kLeastSlender = 100, kMostDegrees = 180;
  if (box.isEmpty() || box.min().head<2>().cwiseAbs().maxCoeff() > kMostDegrees) return;
  const double wide = box.sizes().head<2>().maxCoeff(), high = box.sizes().z();
  if (wide > kWidest || high < 1 || high < kLeastSlender * wide) return;
  throw Error(name,
              fmt::format("its points fill {}, a needle; are x and y degrees? Lengths must be "
                          "metres: pdal translate IN OUT reprojection "
                          "--filters.reprojection.out_srs=EPSG:NUMBER",
                          sizesText(box)));
}

}  // namespace

void requireMetres(const Frame& frame, const std::string& name) {
  if (frame.sensor != Sensor::cloud) return;
  const Eigen::AlignedBox3d box = boxWithoutStrays(frame.cloud);
  requireNoDegrees(box, name);
  // A country is high, too, but far wider.
  if (!isUnlikely(box, frame.cloud.size(), {1000, 0.02F, 10})) return;
  throw Error(name, fmt::format("its points fill {}; are their units millimetres, or "
                                "centimetres (0.01)? Lengths must be metres: {}",
                                sizesText(box), toMetres(0.001)));
}

std::optional<std::string> checkMetres(const Place& place) {
  if (place.sensor != Sensor::cloud) return std::nullopt;
  Eigen::AlignedBox3d box = boxWithoutStrays(
      place.graph.size(), [&](std::size_t i) { return place.graph.vertices[i].position; });
  if (place.cloud.empty()) {
    if (!isUnlikely(box, place.graph.size(), {30, 0.3F, 10})) return std::nullopt;
    return fmt::format(
        "its things fill {}; are their units millimetres or centimetres? Lengths "
        "must be metres",
        sizesText(box));
  }
  box.extend(boxWithoutStrays(place.cloud));
  if (!isUnlikely(box, place.cloud.size(), {100, 0.05F, 2})) return std::nullopt;
  return fmt::format(
      "its points fill {}, sparsely; are their units centimetres? Lengths must be "
      "metres: {}",
      sizesText(box), toMetres(0.01));
}

std::optional<std::string> checkUpright(const Place& place) {
  if (place.sensor != Sensor::cloud || place.cloud.empty()) return std::nullopt;
  const auto [x, y, z] = extentsOf(place.cloud);
  const int flat = x.reach() < y.reach() ? 0 : 1;
  const Extent& along = flat == 0 ? x : y;
  if (z.reach() < kTall_m || along.reach() >= kNarrow * z.reach()) return std::nullopt;
  // Most of what is measured of a place is its ground and what stands low.
  const int sign = along.middle - along.low <= along.high - along.middle ? 1 : -1;
  return fmt::format(
      "most of its points lie within {:.0f} m along {} and within {:.0f} m along z; is {}{} up "
      "there? {}",
      along.reach(), "xy"[flat], z.reach(), sign < 0 ? "-" : "", "xy"[flat],
      howToMove(turnUpright(flat, sign)));
}

void DepthPlausibility::add(const LiftCounts& counts, const LabelledCloud& cloud,
                            const Eigen::Vector3d& sensor, double metres) {
  counts_.lifted += counts.lifted;
  counts_.out_of_range += counts.out_of_range;
  if (cloud.empty()) return;
  const Eigen::Vector3f here = (sensor - cloud.origin).cast<float>();
  std::vector<float> ranges;
  for (const Point& p : cloud.points) ranges.push_back((p.getVector3fMap() - here).norm());
  median_ranges_.push_back(static_cast<float>(metres) * medianOf(std::move(ranges)));
}

void DepthPlausibility::require(const FrameSource& source) const {
  requireInRange(counts_, source);
  if (median_ranges_.empty()) return;
  const float range_m = medianOf(median_ranges_);
  if (range_m <= kSmallRange_m || range_m >= kLargeRange_m) requireScale(source);
  requireKindOfDepth(source);
}

}  // namespace xview
