// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "xview/base/semantic_place.h"

namespace xview::search {

/// Distance from a query sample to the nearest map sample of its channel, in classes; the last
/// class is "the map never saw this place".
constexpr int kUnknownBin = kDistanceBins;
constexpr std::array<float, kDistanceBins - 1> kBinLimits_m = {0.3f, 0.6f, 1.0f, 1.5f,
                                                               2.0f, 3.0f, 5.0f, 9.0f};

/// From where a query saw the place that its map shows: what is seen well from the ground is seen
/// badly from the air. `ground` are two views of one kind, `air` is a query from the air in a map
/// from the ground, `ground_in_air` the reverse.
enum class Viewpoint { ground, air, ground_in_air };
constexpr std::size_t kViewpoints = 3;
inline Viewpoint viewpointOf(bool query_is_aerial, bool map_is_aerial) {
  if (query_is_aerial == map_is_aerial) return Viewpoint::ground;
  return query_is_aerial ? Viewpoint::air : Viewpoint::ground_in_air;
}

/// How often the distance of a sample falls into each class, at the true pose and at wrong poses on
/// the road. Counts, so that tables of several recordings can be added.
struct DistanceCounts {
  std::array<double, kDistanceBins> at_true{};
  std::array<double, kDistanceBins> at_wrong{};
};

/// The learned likelihoods of all channels and view-points.
struct LikelihoodTable {
  std::array<std::array<DistanceCounts, kBevChannels>, kViewpoints> counts{};

  DistanceCounts& at(Viewpoint v, BevChannel c) {
    return counts[static_cast<std::size_t>(v)][static_cast<std::size_t>(c)];
  }
  const DistanceCounts& at(Viewpoint v, BevChannel c) const {
    return counts[static_cast<std::size_t>(v)][static_cast<std::size_t>(c)];
  }
  void add(const LikelihoodTable& other);
};

/// log P(class | true pose) / P(class | wrong pose) per channel and distance class [nats]; exactly
/// 0 for unknown area.
struct LogRatios {
  std::array<std::array<float, kDistanceBins + 1>, kBevChannels> value{};
  std::array<float, kBevChannels> expected{};  ///< mean ratio of a sample at the true pose
};

/// Smoothed ratios, clipped below at -2.5 because one unseen house is many samples. `map_null`, if
/// given, holds how distances are distributed at wrong poses in this very map; it counts with
/// weight `mix` in [0, 1].
LogRatios logRatios(const LikelihoodTable& table, Viewpoint viewpoint, const MapNull* map_null,
                    double mix);

/// The table that comes with the program, learned on recordings of rendered towns with clean and
/// noisy labels.
const LikelihoodTable& defaultLikelihoods();

/// Text form: one line per view-point, channel and hypothesis. parseLikelihoods
/// throws Error with path:line; lines that are not there count nothing.
std::string toText(const LikelihoodTable& table);
LikelihoodTable parseLikelihoods(const std::string& text, const std::string& path);
/// Names instead of a file: what was learned in rooms, and in towns for what rooms do not have; in
/// towns whose labels were withheld, so that classes came from shapes; and what holds for shapes in
/// a map whose classes come from labels. From the ground that is what was learned from labels, from
/// the air, where shapes are coarse, what was learned from shapes.
constexpr const char *kRooms = "rooms", *kShapes = "shapes", *kShapesInLabels = "shapes_in_labels";
/// The text form from a file, or what a name stands for. Throws Error if it cannot be read or holds
/// no counts at all.
LikelihoodTable readLikelihoods(const std::string& path);

}  // namespace xview::search
