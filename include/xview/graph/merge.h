// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "xview/types/blob.h"
#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"

namespace xview {

struct MergeOptions {
  std::string mode = "running_mean";
  double first_observation_m = 10;  ///< merge distance of mode first_observation (paper: 10 m SYNTHIA, 15 m others)
  double object_m = 2;              ///< merge distance of objects in mode running_mean
  double surface_m = 3;             ///< spacing of surface vertices in mode running_mean
  int min_observations = 1;         ///< vertices seen in fewer frames are dropped at the end
};

template <class Visitor>
void visit(MergeOptions& o, Visitor&& field) {
  field("mode", o.mode, Choices{{"running_mean", "first_observation"}},
        "running_mean: objects at their mean, surfaces sampled; first_observation: as in the paper");
  field("first_observation_m", o.first_observation_m, Range{0.01, 1e4}, "merge distance of first_observation [m]");
  field("object_m", o.object_m, Range{0.01, 1e4}, "merge distance of objects in running_mean [m]");
  field("surface_m", o.surface_m, Range{0.01, 1e4}, "spacing of surface vertices in running_mean [m]");
  field("min_observations", o.min_observations, Range{1, 1e6}, "drop vertices seen in fewer frames");
}

/// Merges the blobs of successive frames into the vertices of one place graph (paper section III-C). The cost of a frame does not
/// depend on the size of the graph: vertices are found through a hash of cells.
///
/// first_observation: a blob with a vertex of its class (and instance, if both have one) within the merge distance is absorbed
///   and the vertex stays where it was first seen; otherwise it becomes a vertex. Spaces surfaces evenly.
/// running_mean: object and dynamic classes move to the mean over all frames, weighted by points (capped), nearest vertex first
///   and one vertex per blob and frame; surface classes get vertices on a fixed lattice of surface_m from the points of their blobs
///   (addSurfacePoints), at the mean of the points in the cell.
class PlaceGraphBuilder {
 public:
  PlaceGraphBuilder(const LabelSet& labels, const MergeOptions& options);
  ~PlaceGraphBuilder();
  PlaceGraphBuilder(PlaceGraphBuilder&&) noexcept;
  PlaceGraphBuilder& operator=(PlaceGraphBuilder&&) noexcept;

  /// Blobs of one frame in the odometry frame; frames in order.
  void add(const std::vector<Blob>& blobs, std::int64_t frame_number);
  /// Points of surface classes of the same frame; used by running_mean only.
  void addSurfacePoints(const LabelledCloud& cloud, std::int64_t frame_number);
  /// The vertices so far, without edges, in order of first observation.
  SemanticGraph graph() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace xview
