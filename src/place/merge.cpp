// SPDX-License-Identifier: BSD-3-Clause
#include "place/merge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_set>

#include "base/cells.h"
#include "xview/base/error.h"

namespace xview {
namespace {

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
void countFrame(Vertex& vertex, std::int64_t frame) {
  if (vertex.observations == 0) vertex.first_frame = frame;
  if (vertex.observations == 0 || vertex.last_frame != frame) ++vertex.observations;
  vertex.last_frame = frame;
}

void addPoint(Node& node, const Eigen::Vector3d& p, std::int64_t frame) {
  node.sum += p - node.first;
  node.weight += 1;
  node.min = node.min.cwiseMin(p);
  node.max = node.max.cwiseMax(p);
  ++node.vertex.points;
  countFrame(node.vertex, frame);
}

/// Which node is the vertex of a cell of the lattice of surfaces.
struct NodeOfCell {
  ClassCell key;
  std::size_t node;
};

// A blob counts as its points, but not more: a car beside the camera has thousands.
constexpr double kMaxBlobWeight = 200;

constexpr std::size_t kNoNode = std::numeric_limits<std::size_t>::max();
constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

bool agree(std::uint32_t instance_a, std::uint32_t instance_b) {
  return instance_a == 0 || instance_b == 0 || instance_a == instance_b;
}

/// A blob and a vertex that may be the same thing.
struct Pairing {
  double distance2;
  std::size_t blob;
  std::size_t node;
  bool operator<(const Pairing& o) const {
    if (distance2 != o.distance2) return distance2 < o.distance2;
    return blob != o.blob ? blob < o.blob : node < o.node;
  }
};

bool isFirstObservation(const MergeOptions& options) {
  if (options.mode == "first_observation") return true;
  if (options.mode == "running_mean") return false;
  throw UsageError("merge.mode = " + options.mode + ", must be running_mean or first_observation");
}

}  // namespace

struct PlaceGraphBuilder::State {
  State(const LabelSet& label_set, const MergeOptions& merge_options)
      : labels(label_set),
        options(merge_options),
        is_first_observation(isFirstObservation(merge_options)) {}

  bool isUsable(const Blob& blob) const {
    const Role role = labels.role(blob.label);
    if (role == Role::ignored || !blob.position.allFinite()) return false;
    return is_first_observation || space == GraphSpace::image || role != Role::surface;
  }

  bool keepsFirstPosition(std::uint32_t label) const {
    return is_first_observation || labels.role(label) == Role::surface;
  }

  double mergeDistance(std::uint32_t label) const {
    return keepsFirstPosition(label) ? options.first_observation_m : options.object_m;
  }

  ClassCell cellOfNode(const Eigen::Vector3d& p, std::uint32_t label) const {
    return cellOf(p, mergeDistance(label), label);
  }

  /// Calls visit(node index, squared distance) for the vertices that may be the blob.
  template <class Visit>
  void forNodesNear(const Blob& blob, Visit&& visit) const {
    const double merge_m = mergeDistance(blob.label);
    nodes_of_cell.forAround(cellOfNode(blob.position, blob.label), [&](std::size_t index) {
      const Vertex& vertex = nodes[index].vertex;
      const double distance2 = (vertex.position - blob.position).squaredNorm();
      if (distance2 <= merge_m * merge_m && agree(vertex.instance, blob.instance))
        visit(index, distance2);
    });
  }

  std::size_t addNode(const Blob& blob) {
    Node node;
    node.first = blob.position;
    node.vertex.label = blob.label;
    node.vertex.position = blob.position;
    node.vertex.extent = blob.max - blob.min;
    node.vertex.observations = 0;
    nodes.push_back(node);
    nodes_of_cell.add(cellOfNode(blob.position, blob.label), nodes.size() - 1);
    return nodes.size() - 1;
  }

  void absorb(Node& node, const Blob& blob, std::int64_t frame) {
    const double weight = std::clamp<double>(blob.points, 1, kMaxBlobWeight);
    const Eigen::Vector3d offset = blob.position - node.first;
    node.sum += weight * offset;
    node.square_sum += weight * offset.squaredNorm();
    node.extent_sum += weight * (blob.max - blob.min);
    node.weight += weight;
    node.vertex.points += blob.points;
    if (node.vertex.instance == 0) node.vertex.instance = blob.instance;
    countFrame(node.vertex, frame);
  }

  void moveToMean(std::size_t index) {
    Node& node = nodes[index];
    const ClassCell before = cellOfNode(node.vertex.position, node.vertex.label);
    node.vertex.position = node.first + node.meanOffset();
    node.vertex.extent = node.extent_sum / node.weight;
    nodes_of_cell.move(before, cellOfNode(node.vertex.position, node.vertex.label), index);
  }

  void absorbByFirstObservation(const std::vector<Blob>& blobs,
                                const std::vector<std::size_t>& which, std::int64_t frame,
                                std::vector<std::size_t>& node_of_blob) {
    for (const std::size_t b : which) {
      std::optional<Pairing> nearest;
      forNodesNear(blobs[b], [&](std::size_t index, double distance2) {
        const Pairing pairing{distance2, 0, index};
        if (!nearest || pairing < *nearest) nearest = pairing;
      });
      node_of_blob[b] = nearest ? nearest->node : addNode(blobs[b]);
      absorb(nodes[node_of_blob[b]], blobs[b], frame);
    }
  }

  std::vector<Pairing> pairings(const std::vector<Blob>& blobs,
                                const std::vector<std::size_t>& usable) const {
    std::vector<Pairing> result;
    for (const std::size_t b : usable) {
      forNodesNear(blobs[b], [&](std::size_t index, double distance2) {
        result.push_back({distance2, b, index});
      });
    }
    std::sort(result.begin(), result.end());
    return result;
  }

  void mergeByMean(const std::vector<Blob>& blobs, const std::vector<std::size_t>& which,
                   std::int64_t frame, std::vector<std::size_t>& node_of_blob) {
    std::vector<std::size_t> taken;  // nodes, sorted
    for (const Pairing& pairing : pairings(blobs, which)) {
      const auto place = std::lower_bound(taken.begin(), taken.end(), pairing.node);
      const bool is_taken = place != taken.end() && *place == pairing.node;
      if (is_taken || node_of_blob[pairing.blob] != kNoNode) continue;
      node_of_blob[pairing.blob] = pairing.node;
      taken.insert(place, pairing.node);
    }
    for (const std::size_t b : which) {
      if (node_of_blob[b] == kNoNode) node_of_blob[b] = addNode(blobs[b]);
      absorb(nodes[node_of_blob[b]], blobs[b], frame);
      moveToMean(node_of_blob[b]);
    }
  }

  /// The node that each blob became part of, or kNoNode.
  std::vector<std::size_t> merge(const std::vector<Blob>& blobs, std::int64_t frame) {
    std::vector<std::size_t> fixed, moving;
    for (std::size_t b = 0; b < blobs.size(); ++b) {
      if (isUsable(blobs[b])) (keepsFirstPosition(blobs[b].label) ? fixed : moving).push_back(b);
    }
    std::vector<std::size_t> node_of_blob(blobs.size(), kNoNode);
    absorbByFirstObservation(blobs, fixed, frame, node_of_blob);
    mergeByMean(blobs, moving, frame, node_of_blob);
    return node_of_blob;
  }

  /// Vertices of surfaces are one per class and cell of a lattice, at the mean of the points in it,
  /// however much of the surface was seen.
  void addSurfacePoints(const LabelledCloud& cloud, std::int64_t frame) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const std::uint32_t label = cloud.points[i].label;
      const Eigen::Vector3d p = cloud.position(i);
      if (labels.role(label) != Role::surface || !p.allFinite()) continue;
      const ClassCell cell = cellOf(p, options.surface_m, label);
      const std::size_t number = surface_cells.numberOf(cell, [&] {
        Node node;
        node.is_surface = true;
        node.first = node.min = node.max = p;
        node.vertex.label = label;
        node.vertex.observations = 0;
        nodes.push_back(node);
        return NodeOfCell{cell, nodes.size() - 1};
      });
      addPoint(nodes[surface_cells[number].node], p, frame);
    }
  }

  bool isKept(const Node& node) const {
    return !node.is_surface ||
           node.vertex.points >= static_cast<std::uint32_t>(options.min_surface_points);
  }

  Vertex finished(const Node& node) const {
    Vertex vertex = node.vertex;
    if (node.is_surface) {
      vertex.position = node.first + node.meanOffset();
      vertex.extent = node.max - node.min;
      return vertex;
    }
    if (vertex.observations < 2) return vertex;
    const double about_first = node.square_sum / node.weight;
    const double variance = keepsFirstPosition(vertex.label)
                                ? about_first
                                : about_first - node.meanOffset().squaredNorm();
    vertex.sigma_m = std::sqrt(std::max(0.0, variance) / 3);
    return vertex;
  }

  LabelSet labels;
  MergeOptions options;
  bool is_first_observation;
  GraphSpace space = GraphSpace::cloud;
  std::vector<Node> nodes;                        ///< in order of first observation
  std::unordered_set<std::uint64_t> image_edges;  ///< smaller node * 2^32 + larger node
  CellLists nodes_of_cell;                        ///< of side mergeDistance(label)
  CellTable<NodeOfCell> surface_cells;
};

PlaceGraphBuilder::PlaceGraphBuilder(const LabelSet& labels, const MergeOptions& options)
    : state_(std::make_unique<State>(labels, options)) {}
PlaceGraphBuilder::~PlaceGraphBuilder() = default;

void PlaceGraphBuilder::add(const std::vector<Blob>& blobs, std::int64_t frame_number) {
  state_->merge(blobs, frame_number);
}

void PlaceGraphBuilder::addImageBlobs(const std::vector<Blob>& blobs, const BlobEdges& edges,
                                      std::int64_t frame_number) {
  state_->space = GraphSpace::image;
  const std::vector<std::size_t> node_of_blob = state_->merge(blobs, frame_number);
  for (const auto& [a, b] : edges) {
    const auto [low, high] = std::minmax(node_of_blob[a], node_of_blob[b]);
    if (high != kNoNode && low != high) state_->image_edges.insert(low << 32 | high);
  }
}

void PlaceGraphBuilder::addSurfacePoints(const LabelledCloud& cloud, std::int64_t frame_number) {
  if (!state_->is_first_observation) state_->addSurfacePoints(cloud, frame_number);
}

SemanticGraph PlaceGraphBuilder::graph() const {
  SemanticGraph graph;
  graph.space = state_->space;
  std::vector<std::uint32_t> vertex_of_node;
  for (const Node& node : state_->nodes) {
    const bool is_kept = state_->isKept(node);
    vertex_of_node.push_back(is_kept ? static_cast<std::uint32_t>(graph.size()) : kNoVertex);
    if (is_kept) graph.vertices.push_back(state_->finished(node));
  }
  BlobEdges edges;
  for (const std::uint64_t edge : state_->image_edges) {
    const std::uint32_t a = vertex_of_node[edge >> 32];
    const std::uint32_t b = vertex_of_node[edge & 0xFFFFFFFF];
    if (a != kNoVertex && b != kNoVertex) edges.emplace_back(a, b);
  }
  graph.setEdges(edges);
  return graph;
}

}  // namespace xview
