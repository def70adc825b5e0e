// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include "baselines/baseline.h"
#include "baselines/consistency_graph.h"
#include "pose/align.h"

namespace xview {
namespace {

constexpr std::size_t kMostPairs = 12000;
constexpr int kBudget = 100000;

std::vector<Eigen::Vector3d> positionsOf(const SemanticGraph& graph) {
  std::vector<Eigen::Vector3d> positions;
  for (const Vertex& v : graph.vertices) positions.push_back(v.position);
  return positions;
}

class AllPairsClique final : public Baseline {
 public:
  AllPairsClique(const SemanticGraph& map, const LabelSet& labels)
      : labels_(labels), map_(objectsOf(map, labels)), positions_(positionsOf(map_)) {}

  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& graph) const override {
    const SemanticGraph query = objectsOf(graph, labels_);
    std::vector<Correspondence> putative;
    for (std::uint32_t q = 0; q < query.size(); ++q) {
      for (std::uint32_t m = 0; m < map_.size(); ++m) {
        if (query.vertices[q].label == map_.vertices[m].label) putative.push_back({q, m, 1.0f});
      }
    }
    const std::vector<Eigen::Vector3d> positions = positionsOf(query);
    const ConsistencyGraph agreement =
        pairwiseConsistency(positions, positions_, putative, {}, kMostPairs);
    std::vector<Eigen::Vector3d> from, to;
    for (const std::uint32_t k : maximumClique(agreement, kBudget).nodes) {
      from.push_back(positions[putative[k].query]);
      to.push_back(positions_[putative[k].map]);
    }
    const pose::Alignment fit = pose::alignPointsInYaw(from, to);
    if (!fit.valid) return std::nullopt;
    return fit.T_target_source;
  }

 private:
  LabelSet labels_;
  SemanticGraph map_;
  std::vector<Eigen::Vector3d> positions_;
};

}  // namespace

std::unique_ptr<Baseline> makeAllPairsClique(const SemanticGraph& map, const LabelSet& labels) {
  return std::make_unique<AllPairsClique>(map, labels);
}

SemanticGraph objectsOf(const SemanticGraph& graph, const LabelSet& labels) {
  SemanticGraph objects;
  for (const Vertex& v : graph.vertices) {
    if (labels.role(v.label) == Role::object || labels.role(v.label) == Role::dynamic)
      objects.vertices.push_back(v);
  }
  objects.neighbours.resize(objects.size());
  return objects;
}

}  // namespace xview
