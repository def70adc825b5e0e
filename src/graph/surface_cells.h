// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "place_node.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview {

/// Vertices of surfaces: one per class and cell of a lattice, at the mean of the points in it,
/// however much of the surface was seen.
class SurfaceCells {
 public:
  explicit SurfaceCells(double side_m) : side_m_(side_m) {}

  /// Points of surface classes; new cells are appended to `nodes`.
  void add(const LabelledCloud& cloud, const LabelSet& labels, std::int64_t frame,
           std::vector<Node>& nodes);

 private:
  std::size_t nodeOf(const CellKey& key, const Eigen::Vector3d& p, std::vector<Node>& nodes);

  double side_m_;
  std::unordered_map<CellKey, std::size_t, CellKeyHash> node_of_cell_;
};

}  // namespace xview
