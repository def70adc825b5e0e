// SPDX-License-Identifier: BSD-3-Clause
#include "xview/depth_plausibility.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <utility>

#include "pipeline/depth_witnesses.h"
#include "xview/types/error.h"
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kFewLifted =
    0.02;  ///< less of what was measured in range is no unusual recording any more
/// Half of a frame nearer than the one: a room, or a wrong scale; farther than the other: a flight,
/// or a wrong scale.
constexpr float kSmallRange_m = 5, kLargeRange_m = 40;
constexpr double kSeen = 0.05;  ///< share of pixels that both frames see
constexpr double kAgree = 0.7;  ///< share of these that agree if the scale is right: 0.85 to 1.00
                                ///< in towns, noisy ones included
constexpr double kBetter =
    0.003;  ///< more agreement for the other kind of depth: 0.006 to 0.5 in towns
constexpr double kContradict =
    0.6;  ///< and if it is ten times too small, over that share: 0.1 to 0.5 near the ground
/// And if it is ten times too large, over that share, where the motion is next to nothing: 0.67 to
/// 0.84 near the ground. Right ones agree better than a tenth of them anywhere.
constexpr double kContradictLarge = 0.88;

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

std::string scaleHint(const FrameSource& source, float median_m) {
  if (source.sensor() != Sensor::camera)
    return fmt::format("half of the points are beyond {:.4g} m; are their coordinates in metres?",
                       median_m);
  return fmt::format("the median depth is {:.4g} m with depth_scale {:g}; is that scale right?",
                     median_m, source.read(source.size() / 2).camera.depth_scale);
}

void requireInRange(const graph::LiftCounts& counts, const FrameSource& source) {
  const auto measured = static_cast<double>(counts.lifted + counts.out_of_range);
  if (measured == 0 || static_cast<double>(counts.lifted) >= kFewLifted * measured) return;
  throw Error(source.name(),
              fmt::format("{:.1f} % of the measurements are out of range (lift.min_range_m to "
                          "lift.max_range_m): {}",
                          100.0 * static_cast<double>(counts.out_of_range) / measured,
                          scaleHint(source, medianMeasured(source.read(source.size() / 2)))));
}

void requireScale(const FrameSource& source) {
  const auto factor = missingFactor(source);
  if (!factor) return;
  throw Error(
      source.name(),
      fmt::format(
          "depths contradict the poses, but would agree with them if they were {:g} times as "
          "large: {}",
          *factor, scaleHint(source, medianMeasured(source.read(source.size() / 2)))));
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

void requireMetres(const Frame& frame, const std::string& name) {
  constexpr float kHighest_m = 1000, kSparsest_m = 10;
  constexpr float kSteepest = 0.02F;  // a country is high, too, but far wider
  if (frame.sensor != Sensor::cloud || frame.cloud.empty()) return;
  Eigen::AlignedBox3f box;
  for (const Point& p : frame.cloud.points) {
    if (p.getVector3fMap().allFinite()) box.extend(p.getVector3fMap());
  }
  const Eigen::Vector3f size = box.sizes();
  const float area = box.volume() / size.minCoeff();
  if (!(size.minCoeff() >= std::max(kHighest_m, kSteepest * size.maxCoeff())) ||
      area < kSparsest_m * kSparsest_m * static_cast<float>(frame.cloud.size()))
    return;
  throw Error(name, fmt::format("its points fill {:.0f} x {:.0f} x {:.0f} m; are their units "
                                "millimetres? Lengths must be metres",
                                size.x(), size.y(), size.z()));
}

void DepthPlausibility::add(const graph::LiftCounts& counts, const LabelledCloud& cloud,
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
