// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/types/cells.h"
#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview::graph {

/// A vertex in the making. Sums are relative to the first position, so that they stay small.
struct Node {
  Vertex vertex;  ///< position, extent: kept up to date
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();         ///< weight * (position - first)
  Eigen::Vector3d extent_sum = Eigen::Vector3d::Zero();  ///< weight * extent
  double square_sum = 0;                                 ///< weight * |position - first|^2
  double weight = 0;
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< surfaces only
  bool is_surface = false;

  Eigen::Vector3d meanOffset() const { return sum / weight; }
};

/// Counts the frame once, however many blobs or points of it arrive.
void countFrame(Vertex& vertex, std::int64_t frame);

/// Vertices of surfaces: one per class and cell of a lattice, at the mean of the points in it,
/// however much of the surface was seen.
class SurfaceCells {
 public:
  explicit SurfaceCells(double side_m) : side_m_(side_m) {}

  /// Points of surface classes; new cells are appended to `nodes`.
  void add(const LabelledCloud& cloud, const LabelSet& labels, std::int64_t frame,
           std::vector<Node>& nodes);

 private:
  struct NodeOfCell {
    ClassCell key;
    std::size_t node;
  };
  std::size_t nodeOf(const ClassCell& cell, const Eigen::Vector3d& p, std::vector<Node>& nodes);

  double side_m_;
  CellTable<NodeOfCell> cells_;
};

}  // namespace xview::graph
