// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "search/distance_field.h"
#include "search/field.h"
#include "search/likelihoods.h"

namespace xview::search {

/// A query as a bird's-eye view: samples about their centre. It holds one sample per block of
/// surface, so that its evidence does not depend on how densely it was seen.
struct SurfaceSamples {
  struct Sample {
    float x = 0, y = 0;  ///< relative to the centre [m]
    std::uint8_t channel = 0;
    float z = 0;  ///< height of the ground there, in the query frame
  };
  struct Ground {
    float x = 0, y = 0, z = 0;  ///< relative to the centre, z in the query frame
  };
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in the query frame
  bool aerial = false;                               ///< seen from the air
  std::vector<Sample> fine;    ///< one per 3–4 m of surface, and all objects
  std::vector<Sample> coarse;  ///< one per 6–8 m, and all objects
  std::vector<Ground> ground;  ///< heights of ground cells, one per 2 m
};

SurfaceSamples surfaceSamples(const BevGrid& view);

/// Those within `radius_m` of a point of the query frame, about that point; with all of the ground,
/// whose height is that of the whole.
SurfaceSamples partOf(const SurfaceSamples& samples, const Eigen::Vector2d& centre,
                      double radius_m);

/// How far the farthest sample is from the centre [m].
double radiusOf(const std::vector<SurfaceSamples::Sample>& samples);

/// Anything that stands there, whatever its class.
constexpr std::array<BevChannel, 2> kObstacles = {BevChannel::obstacle_low,
                                                  BevChannel::obstacle_high};

/// What obstacles add to a score, and what they would to that of a true pose, where the map was
/// seen.
PartScore obstaclesIn(const std::vector<SampleEvidence>& evidence);

/// Share of what stands that speaks against a pose; see Visibility::conflict_ratio.
double conflictRatioOf(const std::vector<SampleEvidence>& evidence);

/// Weight of a fine or coarse sample: one that stands for a larger block counts more, so that
/// evidence per square metre (areas) or metre (lines) is constant.
double sampleWeight(BevChannel channel, bool coarse);

/// Log ratios times the weight of a sample of the channel.
struct WeightedRatios {
  std::array<std::array<float, kDistanceBins + 1>, kBevChannels> value{};
  std::array<float, kBevChannels> expected{};
};

/// Score of gravity-aligned poses of the centre of samples in plan coordinates. All must outlive
/// it.
class SurfaceScore {
 public:
  SurfaceScore(const DistanceField& field, const WeightedRatios& ratios,
               const std::vector<SurfaceSamples::Sample>& samples);

  double operator()(const PlacePose& pose) const;
  /// Pattern search: steps of `step_m` and `step_rad`, halved `levels - 1` times.
  PlacePose refineLocally(PlacePose start, double step_m, double step_rad, int levels) const;
  /// The distance class of each sample.
  std::vector<std::uint8_t> distanceBins(const PlacePose& pose) const;
  /// What the score is made of; `hypothesis` holds the pose.
  PlaceHypothesis details(const PlacePose& pose, PlaceHypothesis hypothesis) const;
  /// What each sample says.
  std::vector<SampleEvidence> evidence(const PlacePose& pose) const;

 private:
  /// A few samples, coordinate by coordinate, as processors turn them at once.
  struct Lanes {
    static constexpr std::size_t kCount = 8;
    std::array<float, kCount> x{}, y{};
    std::array<std::uint8_t, kCount> channel{};
    std::size_t count = 0;
  };
  template <class Cells>
  double scoreIn(const Cells& where, const PlacePose& pose) const;

  const DistanceField& field_;
  const WeightedRatios& ratios_;
  const std::vector<SurfaceSamples::Sample>& samples_;
  std::vector<Lanes> lanes_;  ///< of the samples, in their order
  double radius_m_;
};

}  // namespace xview::search
