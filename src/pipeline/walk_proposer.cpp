// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/walk_proposer.h"

#include <algorithm>

#include "pipeline/walk_graph.h"
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

/// Both frames are gravity-aligned as a rule; then four degrees of freedom fit about as well as six, and are safer.
Alignment alignUprightIfPossible(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to) {
  constexpr double kMuchWorse = 1.3, kSlack_m = 0.3;
  const Alignment free = alignPoints(from, to), upright = alignPointsUpright(from, to);
  if (!free.valid) return upright;
  return upright.valid && upright.rms_m <= kMuchWorse * free.rms_m + kSlack_m ? upright : free;
}

/// The clique and every correspondence that agrees with most of it.
std::vector<std::uint32_t> agreeingWith(const ConsistencyGraph& agreement, const std::vector<std::uint32_t>& clique) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t i = 0; i < agreement.size(); ++i) {
    std::size_t agreeing = 0;
    for (const std::uint32_t j : clique) agreeing += i == j || agreement.connected(i, j);
    if (4 * agreeing >= 3 * clique.size()) result.push_back(i);
  }
  return result;
}

}  // namespace

struct WalkProposer::Index {
  Index(const SemanticGraph& map_graph, const LabelSet& label_set, const Options& all_options)
      : map(walkGraph(map_graph, label_set, all_options)), labels(label_set), options(all_options), positions(positionsOf(map.graph)) {}
  WalkGraph map;
  LabelSet labels;
  Options options;
  std::vector<Eigen::Vector3d> positions;
};

WalkProposer::WalkProposer(const SemanticGraph& map, const LabelSet& labels, const Options& options)
    : index_(std::make_unique<Index>(map, labels, options)) {}
WalkProposer::~WalkProposer() = default;

WalkProposer::Result WalkProposer::propose(const SemanticGraph& query_graph, int count) const {
  const Options& o = index_->options;
  Result result;
  if (query_graph.empty() || index_->map.graph.empty()) return result;
  Stopwatch watch;
  const WalkGraph query = walkGraph(query_graph, index_->labels, o);
  result.query_vertices = query.graph.size();
  const LabelAlphabet alphabet(query.graph, index_->map.graph);
  const auto describeGraph = [&](const SemanticGraph& graph, std::uint64_t seed) {
    return describe(graph, alphabet, o.walks, o.match.descriptor, seed, o.threads);
  };
  const auto seed = static_cast<std::uint64_t>(o.seed);
  const Descriptors query_words = describeGraph(query.graph, 2 * seed),
                    map_words = describeGraph(index_->map.graph, 2 * seed + 1);
  result.descriptors_ms = watch.lap_ms();
  result.putative = bestMatches(query_words, map_words, o.match, o.threads);
  result.matching_ms = watch.lap_ms();

  const std::vector<Eigen::Vector3d> query_positions = positionsOf(query.graph);
  std::vector<Correspondence> left = result.putative;
  for (int i = 0; i < count && left.size() >= 3; ++i) {
    // Sample consensus fails below about a tenth of inliers, so what cannot agree pairwise goes first.
    const ConsistencyGraph agreement = pairwiseConsistency(query_positions, index_->positions, left, o.consistency);
    const std::vector<Correspondence> core =
        subset(left, agreeingWith(agreement, maximumClique(agreement, o.consistency.clique_budget).nodes));
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
    const Alignment fit = alignUprightIfPossible(from, to);
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
  const auto inFullGraphs = [&](std::vector<Correspondence>& list) {
    for (Correspondence& c : list) c = {query.source[c.query], index_->map.source[c.map], c.similarity};
  };
  inFullGraphs(result.putative);
  for (Proposal& p : result.proposals) inFullGraphs(p.inliers);
  std::stable_sort(result.proposals.begin(), result.proposals.end(),
                   [](const Proposal& a, const Proposal& b) { return a.inliers.size() > b.inliers.size(); });
  return result;
}

}  // namespace xview
