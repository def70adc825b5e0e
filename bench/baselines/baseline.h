// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "xview/base/graph.h"
#include "xview/base/labels.h"

namespace xview {

/// Another way to find a graph of objects in a larger one, to compare with.
class Baseline {
 public:
  virtual ~Baseline() = default;
  /// T_map_query of the best place; nothing if there is none.
  virtual std::optional<Eigen::Isometry3d> localize(const SemanticGraph& query) const = 0;
};

/// X-View as published: walks, 15 best, consensus within 3 m. The same as `--method walks`.
std::unique_ptr<Baseline> makeWalks(const SemanticGraph& map, const LabelSet& labels);

/// Every object of the query with every one of its class in the map; the largest set whose pairwise
/// distances agree within 1.5 m; alignment. Memory and time grow with the square of the putative
/// pairs, so at most 12,000 of them are kept.
std::unique_ptr<Baseline> makeAllPairsClique(const SemanticGraph& map, const LabelSet& labels);

/// Triangles of neighbouring objects, found by their classes and quantised sides, vote for the pose
/// of the query.
std::unique_ptr<Baseline> makeTriangleHash(const SemanticGraph& map, const LabelSet& labels);

/// The vertices as a bare point cloud: PCL's FPFH and SampleConsensusPrerejective. Labels are not
/// used.
std::unique_ptr<Baseline> makeFpfhPrerejective(const SemanticGraph& map);

/// Vertices of object and dynamic classes: those that are things in their own right.
SemanticGraph objectsOf(const SemanticGraph& graph, const LabelSet& labels);

}  // namespace xview
