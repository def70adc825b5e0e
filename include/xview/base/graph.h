// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace xview {

/// A connected region of one class (paper, section III-A): the node of a frame graph.
struct Blob {
  std::uint32_t label = 0;
  std::uint32_t instance = 0;                            ///< 0 = none given by the data
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< mean of the points [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the points [m^2]
  Eigen::Vector3d min = Eigen::Vector3d::Zero();         ///< axis-aligned bounds [m]
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  std::uint32_t points = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
};

/// Pairs of blobs of one frame, smaller index first, sorted.
using BlobEdges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A vertex of a semantic graph: v = {label, position} of the paper, with what later stages need.
struct Vertex {
  std::uint32_t label = 0;
  std::uint32_t instance = 0;                          ///< 0 = none
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] in the frame of the graph
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();    ///< size of the axis-aligned box [m]
  double sigma_m = 0;              ///< standard deviation of the position; 0 = unknown
  std::uint32_t observations = 1;  ///< frames that saw it
  std::uint32_t points = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
};

/// Where the nearness was measured that edges stand for (paper, section III-B).
enum class GraphSpace {
  cloud,  ///< Euclidean distance of the vertices
  image   ///< distance of their contours in an image that shows both
};

const char* toString(GraphSpace space);

/// Vertices with undirected edges. Neighbour lists are sorted, without duplicates and without self
/// loops; j is in neighbours[i] exactly if i is in neighbours[j].
struct SemanticGraph {
  std::vector<Vertex> vertices;
  std::vector<std::vector<std::uint32_t>> neighbours;  ///< one list per vertex
  /// > 0: edges join all vertices that are at most so far apart [m]. Then `neighbours` may be empty
  /// as a whole; makeEdges fills it.
  double edge_radius_m = 0;
  GraphSpace space = GraphSpace::cloud;

  std::size_t size() const { return vertices.size(); }
  bool empty() const { return vertices.empty(); }
  std::size_t edgeCount() const;
  /// Each edge once, (smaller, larger), sorted.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges() const;
  /// Replaces all edges, of a radius as well; duplicates, self loops and order do not matter.
  void setEdges(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges);
};

/// True if the invariants of SemanticGraph hold.
bool isConsistent(const SemanticGraph& graph);

/// Number of connected components.
std::size_t componentCount(const SemanticGraph& graph);

/// A believed identity of a query vertex and a map vertex.
struct Correspondence {
  std::uint32_t query = 0;  ///< index of the vertex in the query graph
  std::uint32_t map = 0;    ///< index of the vertex in the map graph
  float similarity = 0;     ///< of their descriptors, in [0, 1]
};

}  // namespace xview
