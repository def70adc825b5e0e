// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/walk_proposer.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "xview/match/descriptors.h"
#include "xview/pose/align.h"
#include "xview/types/stopwatch.h"
#include "xview/verify/clique.h"
#include "xview/verify/sample_consensus.h"

namespace xview {
namespace {

/// Standard deviation of points across the plane that fits them best.
double thicknessOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points)
    covariance += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
               .eigenvalues()(0)));
}

/// Both frames are gravity-aligned as a rule; then four degrees of freedom fit about as well as
/// six, and are safer. Points in one plane fit their mirror image as well, turned upside down; only
/// gravity tells.
Alignment alignWithGravity(const std::vector<Eigen::Vector3d>& from,
                           const std::vector<Eigen::Vector3d>& to, const std::string& gravity) {
  constexpr double kMuchWorse = 1.3, kSlack_m = 0.3, kFlat_m = 0.3;
  const Alignment free = alignPoints(from, to), upright = alignPointsUpright(from, to);
  if (gravity == "free") return free;
  if (gravity == "aligned" || !free.valid || thicknessOf(from) < kFlat_m) return upright;
  return upright.valid && upright.rms_m <= kMuchWorse * free.rms_m + kSlack_m ? upright : free;
}

/// The clique and every correspondence that agrees with most of it.
std::vector<Correspondence> agreeingWith(const ConsistencyGraph& agreement,
                                         const std::vector<std::uint32_t>& clique,
                                         const std::vector<Correspondence>& all) {
  std::vector<Correspondence> result;
  for (std::uint32_t i = 0; i < agreement.size(); ++i) {
    std::size_t agreeing = 0;
    for (const std::uint32_t j : clique) agreeing += i == j || agreement.connected(i, j);
    if (4 * agreeing >= 3 * clique.size()) result.push_back(all[i]);
  }
  return result;
}

/// A map, or the part of it around a place, ready to be matched.
struct DescribedMap {
  DescribedMap(WalkGraph walk_graph, const Options& o)
      : walks(std::move(walk_graph)),
        positions(positionsOf(walks.graph)),
        alphabet(walks.graph),
        index(match::describe(walks.graph, alphabet, o.walks, o.match.descriptor,
                              2 * static_cast<std::uint64_t>(o.seed) + 1, o.threads)) {}
  WalkGraph walks;
  std::vector<Eigen::Vector3d> positions;
  match::LabelAlphabet alphabet;
  match::DescriptorIndex index;
};

/// Pairs of matches are compared: the bits of all pairs of so many take 12 MB. Long queries have
/// more matches, and a part of them has the same pose.
std::vector<Correspondence> comparable(const std::vector<Correspondence>& matches) {
  constexpr std::size_t kMost = 10000;
  if (matches.size() <= kMost) return matches;
  std::vector<Correspondence> chosen;
  for (std::size_t k = 0; k < kMost; ++k) chosen.push_back(matches[k * matches.size() / kMost]);
  return chosen;
}

/// One round of pruning, sample consensus and SVD; nothing if no pose has enough inliers.
std::optional<WalkProposal> bestPose(const std::vector<Eigen::Vector3d>& query,
                                     const std::vector<Eigen::Vector3d>& map,
                                     const std::vector<Correspondence>& matches, UpKnown up,
                                     const Options& o, WalkProposals& times) {
  Stopwatch watch;
  // Sample consensus fails below about a tenth of inliers, so what cannot agree pairwise goes
  // first.
  const std::vector<Correspondence> compared = comparable(matches);
  const ConsistencyGraph agreement = pairwiseConsistency(query, map, compared, o.consistency);
  const Clique clique = maximumClique(agreement, o.consistency.clique_budget);
  const Consensus consensus = rejectBySampleConsensus(
      query, map, agreeingWith(agreement, clique.nodes, compared), o.consensus);
  times.rejection_ms += watch.lap_ms();
  if (!consensus.found) return std::nullopt;
  WalkProposal pose{consensus.T_map_query,
                    supporters(query, map, matches, consensus.T_map_query, o.consensus.inlier_m),
                    consensus.rms_m};
  std::vector<Eigen::Vector3d> from, to;
  for (const Correspondence& c : pose.inliers) {
    from.push_back(query[c.query]);
    to.push_back(map[c.map]);
  }
  const Alignment fit =
      alignWithGravity(from, to, up == UpKnown::no ? "free" : o.posterior.gravity);
  if (fit.valid) {
    pose = {fit.T_target_source,
            supporters(query, map, matches, fit.T_target_source, o.consensus.inlier_m), fit.rms_m};
  }
  times.pose_ms += watch.lap_ms();
  return pose;
}

std::vector<Correspondence> leftOver(const std::vector<Eigen::Vector3d>& query,
                                     const std::vector<Eigen::Vector3d>& map,
                                     const std::vector<Correspondence>& matches,
                                     const WalkProposal& pose, double reach_m) {
  std::vector<Correspondence> rest;
  for (const Correspondence& c : matches) {
    if ((pose.T_map_query * query[c.query] - map[c.map]).norm() > reach_m) rest.push_back(c);
  }
  return rest;
}

WalkProposals matchGraphs(const WalkGraph& query, const DescribedMap& map, int count, UpKnown up,
                          const Options& o) {
  WalkProposals result;
  Stopwatch watch;
  const match::Descriptors words =
      match::describe(query.graph, map.alphabet, o.walks, o.match.descriptor,
                      2 * static_cast<std::uint64_t>(o.seed), o.threads);
  result.descriptors_ms = watch.lap_ms();
  result.putative = map.index.bestMatches(words, o.match, o.threads);
  result.matching_ms = watch.lap_ms();
  const std::vector<Eigen::Vector3d> query_positions = positionsOf(query.graph);
  std::vector<Correspondence> matches = result.putative;
  while (static_cast<int>(result.poses.size()) < count && matches.size() >= 3) {
    std::optional<WalkProposal> pose =
        bestPose(query_positions, map.positions, matches, up, o, result);
    if (!pose) break;
    matches = leftOver(query_positions, map.positions, matches, *pose, 3 * o.consensus.inlier_m);
    result.poses.push_back(std::move(*pose));
  }
  std::stable_sort(result.poses.begin(), result.poses.end(),
                   [](const WalkProposal& a, const WalkProposal& b) {
                     return a.inliers.size() > b.inliers.size();
                   });
  const auto inFullGraphs = [&](std::vector<Correspondence>& list) {
    for (Correspondence& c : list)
      c = {query.source[c.query], map.walks.source[c.map], c.similarity};
  };
  inFullGraphs(result.putative);
  for (WalkProposal& p : result.poses) inFullGraphs(p.inliers);
  return result;
}

}  // namespace

struct WalkProposer::Index {
  Index(const SemanticGraph& map_graph, const LabelSet& label_set, const Options& all_options)
      : map(map_graph), labels(label_set), options(all_options) {
    for (const Vertex& v : map.vertices) plane.emplace_back(v.position.head<2>());
  }

  const DescribedMap& described() const {
    std::call_once(described_once,
                   [&] { described_map.emplace(walkGraph(map, labels, options), options); });
    return *described_map;
  }

  const SemanticGraph& map;
  std::vector<Eigen::Vector2d> plane;  ///< positions of the map's vertices
  LabelSet labels;
  Options options;
  mutable std::once_flag described_once;
  mutable std::optional<DescribedMap> described_map;
};

WalkProposer::WalkProposer(const SemanticGraph& map, const LabelSet& labels, const Options& options)
    : index_(std::make_unique<Index>(map, labels, options)) {}
WalkProposer::~WalkProposer() = default;

WalkGraph WalkProposer::queryGraph(const SemanticGraph& query) const {
  return walkGraph(query, index_->labels, index_->options);
}

WalkProposals WalkProposer::propose(const WalkGraph& query, int count, UpKnown up) const {
  if (query.graph.empty() || index_->map.empty()) return {};
  return matchGraphs(query, index_->described(), count, up, index_->options);
}

WalkGraph WalkProposer::mapAround(const Eigen::Vector2d& place, double radius_m) const {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < index_->plane.size(); ++i) {
    if ((index_->plane[i] - place).squaredNorm() <= radius_m * radius_m) numbers.push_back(i);
  }
  WalkGraph result = walkGraph(inducedGraph(index_->map, numbers), index_->labels, index_->options);
  for (std::uint32_t& source : result.source) source = numbers[source];
  return result;
}

WalkProposals WalkProposer::proposeIn(const WalkGraph& part, const WalkGraph& query) const {
  if (query.graph.empty() || part.graph.empty()) return {};
  return matchGraphs(query, DescribedMap(part, index_->options), 1, UpKnown::yes, index_->options);
}

}  // namespace xview
