// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/cloud_recording.h"
#include "xview/map/semantic_map.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {

/// Map of one or more recordings in one common frame, in the classes of the first (LabelMatch).
/// A recording without labels gets classes from the shapes of its points (withClasses).
/// @param sources   recordings in one odometry frame, which becomes that of the map [m]
/// @param options   size `auto` is measured; the map keeps what it is (SemanticMap::size)
/// @param progress  called with frames that are done, and all of them
/// @param seen      called with every frame, in order
/// Throws Error if a frame cannot be read, if a recording has none of the classes of the first, or
/// if its odometry jumps (OdometryCheck, unless options.odometry.check is off);
/// UsageError if there is no recording, or if one cannot be used with options.graph_space.
map::SemanticMap buildMap(
    const std::vector<const FrameSource*>& sources, const Options& options,
    const Progress& progress = {},
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen = {});
/// The same for an addition to a map. Its null hypothesis is not measured: no query is looked for
/// in it.
map::SemanticMap buildVisit(
    const std::vector<const FrameSource*>& sources, const Options& options,
    const Progress& progress = {},
    const std::function<void(const FrameSource&, const PreprocessedFrame&)>& seen = {});
/// Map of one recording.
map::SemanticMap buildMap(const FrameSource& recording, const Options& options = {});
/// Map of one cloud of PCL in the frame of the map, z up [m]. `labels`: what the field `label` of
/// its points means; without it classes come from shapes, whatever labels the points have. Throws
/// UsageError if there is a label set and the points have no such field.
template <class PointT>
map::SemanticMap buildMap(const pcl::PointCloud<PointT>& cloud, const LabelSet& labels = {},
                          const Options& options = {}) {
  CloudRecording recording(labels);
  recording.add(cloud);
  return buildMap(recording, options);
}
/// Map of a bare graph.
map::SemanticMap buildMap(const SemanticGraph& graph, const LabelSet& labels,
                          const std::string& source, const Options& options);

/// Adds a recording or another map's content to a map in the same frame, in the classes of the map.
/// Throws Error, with the map as it was, if the addition has none of its classes, is tilted against
/// it, or differs from it in graph space or size.
void appendToMap(map::SemanticMap& map, const map::SemanticMap& addition, const Options& options);

/// Another map in the frame of this one, ready for appendToMap().
map::SemanticMap inFrameOf(const map::SemanticMap& map, map::SemanticMap other,
                           const Eigen::Isometry3d& T_map_other);

/// Evidence that two places lie in one frame, as the search weighs it: every sample of one place
/// against the null hypothesis in the other, where both were observed.
struct FrameEvidence {
  double score = 0;     ///< of the frames as they are; below 0 chance explains it better [nats]
  double expected = 0;  ///< what two visits of one place would score on average [nats]
  double nearby = 0;    ///< score of the best pose within a few metres [nats]
  double shift_m = 0;   ///< how far the other place moves to it
  double area_m2 = 0;   ///< of BEV cells that both observed; 0 for bare graphs

  double agreement() const { return score / expected; }
  bool contradicts() const { return score < 0; }
};

/// Nothing if the places have too little in common to tell, or differ in size.
std::optional<FrameEvidence> evidenceOfOneFrame(const map::SemanticMap& map,
                                                const map::SemanticMap& other,
                                                const Options& options);

/// True if `other` comes from a recording that is in the map already: its key frames have the same
/// relative poses at the same times. Also if a source of the same name was where `other` was at
/// most of its times.
bool holdsSameDrive(const map::SemanticMap& map, const map::SemanticMap& other);

/// A query from a saved session: everything the map knows, answered for its last key frame.
Query makeQuery(map::SemanticMap map, const Options& options);

}  // namespace xview
