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
  std::vector<std::int64_t> frames;  ///< that saw it, counted from 1; objects of running_mean only
  bool is_surface = false;

  Eigen::Vector3d meanOffset() const { return sum / weight; }
};

/// Counts the frame once, however many blobs or points of it arrive.
void countFrame(Vertex& vertex, std::int64_t frame);

/// Adds the observations of the other one.
void join(Node& node, const Node& other);

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

/// For each node the number of the one that it is the same thing as: itself, or one that more
/// frames saw. The same thing is what a network calls a truck in some frames and a car in others:
/// another class of the same role within reach_m of one that at least three frames saw, its box
/// over the other's, and seldom (in at most a quarter of the frames of the rarer one) both in one
/// frame. What stands beside something else is seen together with it. Nodes without frames stay
/// alone.
std::vector<std::size_t> sameThings(const std::vector<Node>& nodes, const LabelSet& labels,
                                    double reach_m);

}  // namespace xview::graph
