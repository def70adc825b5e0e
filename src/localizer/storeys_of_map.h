// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "map/common_detail.h"
#include "search/search.h"
#include "xview/map/semantic_map.h"
#include "xview/options.h"

namespace xview {

struct Candidates;
namespace verdict {
struct Evidence;
}

struct StoreyOfMap {
  double bottom = 0;  ///< height from which on it holds
  /// Its key frames, vertices and points, and a view of these. One that nobody walked through has
  /// key frames in squares of its floor.
  map::SemanticMap map;
  std::vector<std::size_t> key_frames;  ///< positions among those of the whole map, of these only
};

/// The storeys of an upright map, from below. None if it is one plane (StoreyFinder).
std::vector<StoreyOfMap> storeysOf(const map::SemanticMap& upright);

/// The field of the view of an upright map, which must outlive it; of several storeys if it has
/// them. `detail`: what of the classes of the map is told apart (map::reduced).
std::unique_ptr<const search::Field> surfaceFieldOf(const map::SemanticMap& upright,
                                                    const Options& options,
                                                    const map::CommonDetail& detail = {});

/// From the second-best place up to the best one.
double heightBetween(const std::vector<search::PlaceHypothesis>& places);
/// Nobody changes floors unseen: what is in another storey than the pose that is expected goes.
void keepStoreyOf(const Eigen::Isometry3d& T_expected, Candidates& found);
/// How many storeys the map has, and how well another one fits where the best place is.
void addStoreys(const Candidates& found, const map::SemanticMap& map, verdict::Evidence& evidence);
/// Names the floors of the two best places. `size`: see kTownScale.
void tellStoreys(const Candidates& found, double size, Localization& answer);

}  // namespace xview
