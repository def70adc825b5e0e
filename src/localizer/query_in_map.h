// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "map/common_detail.h"
#include "search/field.h"
#include "xview/base/semantic_place.h"
#include "xview/localizer.h"

namespace xview {

/// Which way is up in the frame of a query, and how long its metre is in the map:
/// p_upright = R_up * (scale * p_query). What is known is one guess; an unknown up and an unknown
/// scale are lists of them, and nothing but this file knows about tilts.
struct FrameHypothesis {
  Eigen::Quaterniond R_up = Eigen::Quaterniond::Identity();
  double scale = 1;
};

/// Nobody drives through a place that is smaller than a town: walls are near, and alike on all
/// sides, whatever table of likelihoods the options name.
inline search::Surroundings surroundingsOf(double size) {
  return size < kTownScale ? search::Surroundings::rooms : search::Surroundings::town;
}

/// What a search in a place of this size works with, at canonical scale: unless the options name
/// a table of likelihoods, that of its surroundings. Classes from shapes are seen again less often.
Options optionsOfSearch(const Options& options, double size, const LabelSet& map_labels);

/// That of a map whose view and vertices may be stored; see gravityOf() of a place.
Gravity gravityOf(const map::SemanticMap& map, const std::string& mode);
/// The map in a gravity-aligned frame; nothing if its own is one.
std::optional<map::SemanticMap> gravityAlignedMap(const map::SemanticMap& map,
                                                  const Eigen::Quaterniond& R_up);

/// The query with every length times `scale`, about the origin of its frame.
Query scaledQuery(const Query& query, double scale);
/// The query in the frame that `R_up` makes of its own. Its BEV grid is drawn upright
/// already and stays where it is.
Query turnedQuery(const Query& query, const Eigen::Quaterniond& R_up);
/// The query and its BEV grid turned by a few degrees more. Samples and cells are taken to
/// lie on the ground below them, so what stands h metres above it is drawn h * sin(angle) away.
Query tiltedQuery(const Query& query, const Eigen::Quaterniond& R);

/// Sorted, one per cell: a measured one if there is one, else the first.
std::vector<GroundCell> onePerCell(std::vector<GroundCell> cells);

/// A query in the classes of a map that mean the same, and at canonical scale, as all that an
/// index knows. It is copied only if it has to be changed. Throws Error if it was made with lengths
/// of another size.
struct QueryInMap : CopyOnChange<Query> {
  QueryInMap(const Query& given, const LabelSet& map_labels, double map_size,
             const ClassNames& names = ClassNames::shipped());
};

/// A query as a guess has it. It is copied only if it has to be changed.
struct AlignedQuery : CopyOnChange<Query> {
  AlignedQuery(const Query& given, const FrameHypothesis& guess);
};

/// A cloud or graph whose origin lies outside of what it shows (lifted from a drive, cut from a
/// town) was not seen from there, and on a lever of hundreds of metres a tenth of a degree looks
/// like another place. The same query with its centre as its pose, in which it can be judged,
/// refined and looked for; nothing if its poses were view-points.
std::optional<Query> seenFromItsCentre(const Query& query);

/// Scales 6 % apart: a window of 60 m then fits within 1 m at its ends for one of them.
std::vector<double> scalesIn(const ScaleRange& range);
constexpr double kScaleStep = 0.06;

/// The middle of what was seen, which a change of the scale should leave where it is.
Eigen::Vector3d middleOf(const Query& query);

/// The gravity-aligned pose that heads the same way and puts a point of the query in the same
/// place.
Eigen::Isometry3d alignedAbout(const Eigen::Vector3d& point, const Eigen::Isometry3d& T);

}  // namespace xview
