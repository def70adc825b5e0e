// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/walk_proposer.h"

#include <algorithm>

#include "xview/match/descriptors.h"
#include "xview/pose/align.h"
#include "xview/types/stopwatch.h"
#include "xview/verify/clique.h"
#include "xview/verify/sample_consensus.h"

namespace xview {
namespace {

std::vector<Eigen::Vector3d> positionsOf(const SemanticGraph& graph) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(graph.size());
  for (const Vertex& v : graph.vertices) positions.push_back(v.position);
  return positions;
}

std::vector<Correspondence> subset(const std::vector<Correspondence>& all, const std::vector<std::uint32_t>& chosen) {
  std::vector<Correspondence> result;
  result.reserve(chosen.size());
  for (const std::uint32_t i : chosen) result.push_back(all[i]);
  return result;
}

}  // namespace

struct WalkProposer::Index {
  Index(const SemanticGraph& map_graph, const Options& all_options)
      : map(map_graph), options(all_options), positions(positionsOf(map_graph)) {}
  const SemanticGraph& map;
  Options options;
  std::vector<Eigen::Vector3d> positions;
};

WalkProposer::WalkProposer(const SemanticGraph& map, const Options& options)
    : index_(std::make_unique<Index>(map, options)) {}
WalkProposer::~WalkProposer() = default;

WalkProposer::Result WalkProposer::propose(const SemanticGraph& query, int count) const {
  const Options& o = index_->options;
  Result result;
  if (query.empty() || index_->map.empty()) return result;
  Stopwatch watch;
  const LabelAlphabet alphabet(query, index_->map);
  const auto describeGraph = [&](const SemanticGraph& graph, std::uint64_t seed) {
    return describe(graph, alphabet, o.walks, o.match.descriptor, seed, o.threads);
  };
  const auto seed = static_cast<std::uint64_t>(o.seed);
  const Descriptors query_words = describeGraph(query, 2 * seed), map_words = describeGraph(index_->map, 2 * seed + 1);
  result.descriptors_ms = watch.lap_ms();
  result.putative = bestMatches(query_words, map_words, o.match, o.threads);
  result.matching_ms = watch.lap_ms();

  const std::vector<Eigen::Vector3d> query_positions = positionsOf(query);
  std::vector<Correspondence> left = result.putative;
  for (int i = 0; i < count && left.size() >= 3; ++i) {
    // Sample consensus fails below about a tenth of inliers, so what cannot agree pairwise goes first.
    const ConsistencyGraph agreement = pairwiseConsistency(query_positions, index_->positions, left, o.consistency);
    const std::vector<Correspondence> core = subset(left, densestCore(agreement));
    const Consensus consensus = rejectBySampleConsensus(query_positions, index_->positions, core, o.consensus);
    result.rejection_ms += watch.lap_ms();
    if (!consensus.found) break;
    Proposal proposal;
    proposal.found = true;
    proposal.T_map_query = consensus.T_map_query;
    proposal.inliers = supporters(query_positions, index_->positions, left, consensus.T_map_query, o.consensus.inlier_m);
    std::vector<Eigen::Vector3d> from, to;
    for (const Correspondence& c : proposal.inliers) {
      from.push_back(query_positions[c.query]);
      to.push_back(index_->positions[c.map]);
    }
    const Alignment fit = alignPoints(from, to);
    if (fit.valid) {
      proposal.T_map_query = fit.T_target_source;
      proposal.rms_m = fit.rms_m;
      proposal.inliers =
          supporters(query_positions, index_->positions, left, fit.T_target_source, o.consensus.inlier_m);
    }
    std::vector<Correspondence> rest;
    for (const Correspondence& c : left) {
      const double d = (proposal.T_map_query * query_positions[c.query] - index_->positions[c.map]).norm();
      if (d > 3 * o.consensus.inlier_m) rest.push_back(c);
    }
    left = std::move(rest);
    result.pose_ms += watch.lap_ms();
    result.proposals.push_back(std::move(proposal));
  }
  std::stable_sort(result.proposals.begin(), result.proposals.end(),
                   [](const Proposal& a, const Proposal& b) { return a.inliers.size() > b.inliers.size(); });
  return result;
}

}  // namespace xview
