// SPDX-License-Identifier: BSD-3-Clause
#include "match/walk_matching.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>

#include "base/cells.h"
#include "match/consistency.h"
#include "match/descriptors.h"
#include "match/sample_consensus.h"
#include "place/edges.h"
#include "pose/align.h"
#include "xview/base/budget.h"

namespace xview::match {
namespace {

/// Map vertices so far beyond a hypothesis take part in walks; edges reach no further.
constexpr double kMargin_m = 20;

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
pose::Alignment alignWithGravity(const std::vector<Eigen::Vector3d>& from,
                                 const std::vector<Eigen::Vector3d>& to,
                                 const std::string& gravity) {
  constexpr double kMuchWorse = 1.3, kSlack_m = 0.3, kFlat_m = 0.3;
  const pose::Alignment free = pose::alignPoints(from, to),
                        upright = pose::alignPointsInYaw(from, to);
  if (gravity == "free") return free;
  if (gravity == "aligned" || !free.valid || thicknessOf(from) < kFlat_m) return upright;
  return upright.valid && upright.rms_m <= kMuchWorse * free.rms_m + kSlack_m ? upright : free;
}

/// See MatchedPose::consensus_m. The scripts that came with the paper ask for more than two to six.
double consensusValue(const WalkGraph& query, const std::vector<Eigen::Vector3d>& map,
                      const MatchedPose& pose) {
  constexpr std::size_t kMany = 6;
  std::vector<double> distances_m;
  for (const Correspondence& c : pose.kept)
    distances_m.push_back((map[c.map] - pose.T_map_query * query.positions[c.query]).norm());
  if (distances_m.size() <= kMany) return std::numeric_limits<double>::infinity();
  std::nth_element(distances_m.begin(), distances_m.begin() + kMany, distances_m.end());
  return distances_m[kMany];
}

/// Sample consensus on `sample`, SVD on its supporters, and what of `matches` agrees with that.
MatchedPose consensusOf(const WalkGraph& query, const std::vector<Eigen::Vector3d>& map,
                        const std::vector<Correspondence>& sample,
                        const std::vector<Correspondence>& matches, const std::string& gravity,
                        const ConsensusOptions& options) {
  MatchedPose result;
  const Consensus consensus = rejectBySampleConsensus(query.positions, map, sample, options);
  if (!consensus.found) return result;
  result.found = true;
  result.T_map_query = consensus.T_map_query;
  result.kept = supporters(query.positions, map, matches, result.T_map_query, options.inlier_m);
  std::vector<Eigen::Vector3d> from, to;
  for (const Correspondence& c : result.kept) {
    from.push_back(query.positions[c.query]);
    to.push_back(map[c.map]);
  }
  const pose::Alignment fit = alignWithGravity(from, to, gravity);
  if (!fit.valid) return result;
  result.T_map_query = fit.T_target_source;
  result.kept = supporters(query.positions, map, matches, result.T_map_query, options.inlier_m);
  return result;
}

void inFullGraphs(const WalkGraph& query, const WalkGraph& map, WalkMatches& matches) {
  const auto renumber = [&](std::vector<Correspondence>& list) {
    for (Correspondence& c : list) c = {query.source[c.query], map.source[c.map], c.similarity};
  };
  renumber(matches.putative);
  for (MatchedPose& pose : matches.poses) renumber(pose.kept);
}

/// The whole map, ready to be matched.
struct DescribedMap {
  DescribedMap(WalkGraph walk_graph, const Options& o)
      : walks(std::move(walk_graph)),
        alphabet(walks.graph),
        index(describe(walks.graph, alphabet, o.walks, 2 * static_cast<std::uint64_t>(o.seed) + 1,
                       o.threads)) {}
  WalkGraph walks;
  LabelAlphabet alphabet;
  DescriptorIndex index;
};

/// Descriptors of single vertices of a graph, made when they are asked for.
class DescriptorCache {
 public:
  DescriptorCache(const SemanticGraph& graph, const LabelAlphabet& alphabet,
                  const WalkOptions& options, std::uint64_t seed)
      : walks_(graph, alphabet, options, seed), made_(graph.size()) {}
  const std::vector<WalkCount>& of(std::uint32_t vertex) {
    std::optional<std::vector<WalkCount>>& made = made_[vertex];
    if (!made) made = walks_.from(vertex);
    return *made;
  }

 private:
  Walks walks_;
  std::vector<std::optional<std::vector<WalkCount>>> made_;
};

/// Candidates of each query vertex under a pose, with their similarity; and for each query vertex
/// with any, how many there are.
struct Candidates {
  std::vector<Correspondence> best;
  std::vector<int> counts;
};

Candidates candidatesUnder(const Eigen::Isometry3d& T_map_query, const WalkGraph& query,
                           const WalkGraph& map, double reach_m, DescriptorCache& of_query,
                           DescriptorCache& of_map) {
  constexpr std::size_t kBest = 3;  // partners of a vertex that sample consensus chooses from
  Candidates candidates;
  for (std::uint32_t i = 0; i < query.graph.size(); ++i) {
    const Eigen::Vector3d p = T_map_query * query.positions[i];
    std::vector<Correspondence> near;
    for (std::uint32_t j = 0; j < map.graph.size(); ++j) {
      if (query.graph.vertices[i].label == map.graph.vertices[j].label &&
          (p - map.positions[j]).squaredNorm() <= reach_m * reach_m)
        near.push_back({i, j, 1.f});
    }
    if (near.empty()) continue;
    candidates.counts.push_back(static_cast<int>(near.size()));
    for (Correspondence& c : near)
      c.similarity = static_cast<float>(similarity(of_query.of(i), of_map.of(c.map)));
    std::stable_sort(near.begin(), near.end(),
                     [](const Correspondence& a, const Correspondence& b) {
                       return a.similarity > b.similarity;
                     });
    near.resize(std::min(near.size(), kBest));
    candidates.best.insert(candidates.best.end(), near.begin(), near.end());
  }
  return candidates;
}

}  // namespace

WalkGraph walkGraph(const SemanticGraph& graph, const LabelSet& labels, const Options& options) {
  WalkGraph result;
  if (graph.space == GraphSpace::image) {
    result.graph = graph;
    result.source.resize(graph.size());
    std::iota(result.source.begin(), result.source.end(), 0u);
  } else {
    const double spacing_m = options.merge.first_observation_m;
    CellLists kept;
    for (std::uint32_t i = 0; i < graph.size(); ++i) {
      const Vertex& v = graph.vertices[i];
      if (labels.role(v.label) == Role::surface) {
        const ClassCell cell = cellOf({v.position.x(), v.position.y(), 0}, spacing_m, v.label);
        const bool is_taken = kept.anyAround(cell, [&](std::size_t k) {
          return !((result.graph.vertices[k].position - v.position).norm() > spacing_m);
        });
        if (is_taken) continue;
        kept.add(cell, result.graph.size());
      }
      result.graph.vertices.push_back(v);
      result.source.push_back(i);
    }
    connectByRadius(result.graph, options.edges, options.walks.nearest);
  }
  for (const Vertex& v : result.graph.vertices) result.positions.push_back(v.position);
  return result;
}

SemanticGraph inducedGraph(const SemanticGraph& graph, const std::vector<std::uint32_t>& numbers) {
  SemanticGraph part;
  part.space = graph.space;
  part.neighbours.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    part.vertices.push_back(graph.vertices[numbers[i]]);
    if (graph.space != GraphSpace::image) continue;
    for (const std::uint32_t j : graph.neighbours[numbers[i]]) {
      const auto at = std::lower_bound(numbers.begin(), numbers.end(), j);
      if (at != numbers.end() && *at == j)
        part.neighbours[i].push_back(static_cast<std::uint32_t>(at - numbers.begin()));
    }
  }
  return part;
}

struct WalkMatcher::Index {
  Index(const SemanticGraph& map_graph, const StoredVertices* stored_vertices,
        const LabelSet& label_set, const Options& all_options)
      : map(map_graph), stored(stored_vertices), labels(label_set), options(all_options) {
    plane.reserve(map.size());
    for (const Vertex& v : map.vertices) plane.emplace_back(v.position.head<2>());
  }
  bool empty() const { return stored ? stored->size() == 0 : map.empty(); }
  const DescribedMap& described() const {
    std::call_once(described_once, [&] {
      const auto describe = [&](const SemanticGraph& graph) {
        described_map.emplace(walkGraph(graph, labels, options), options);
      };
      stored ? describe(stored->whole()) : describe(map);
    });
    return *described_map;
  }
  WalkGraph mapAround(const Eigen::Vector2d& centre, double radius_m) const {
    std::vector<std::uint32_t> numbers;
    const auto isAround = [&](const Eigen::Vector2d& p) {
      return (p - centre).squaredNorm() <= radius_m * radius_m;
    };
    SemanticGraph around;
    if (stored) {
      const auto reach = Eigen::Vector2d::Constant(radius_m);
      stored->forAllIn({centre - reach, centre + reach}, [&](std::uint32_t i, const Vertex& v) {
        if (!isAround(v.position.head<2>())) return;
        numbers.push_back(i);
        around.vertices.push_back(v);
      });
    } else {
      for (std::uint32_t i = 0; i < plane.size(); ++i) {
        if (isAround(plane[i])) numbers.push_back(i);
      }
      around = inducedGraph(map, numbers);
    }
    WalkGraph part = walkGraph(around, labels, options);
    for (std::uint32_t& source : part.source) source = numbers[source];
    return part;
  }
  const SemanticGraph& map;
  const StoredVertices* stored;
  std::vector<Eigen::Vector2d> plane;  ///< positions of the map's vertices, unless stored
  LabelSet labels;
  Options options;
  mutable std::once_flag described_once;
  mutable std::optional<DescribedMap> described_map;
};

WalkMatcher::WalkMatcher(const SemanticGraph& map, const StoredVertices* stored,
                         const LabelSet& labels, const Options& options)
    : index_(std::make_unique<Index>(map, stored, labels, options)) {}
WalkMatcher::~WalkMatcher() = default;

WalkGraph WalkMatcher::queryGraph(const SemanticGraph& query) const {
  return walkGraph(query, index_->labels, index_->options);
}

WalkMatches WalkMatcher::matchEverywhere(const WalkGraph& query, int count, bool up_known,
                                         Timings& timing_ms) const {
  WalkMatches result;
  if (query.graph.empty() || index_->empty()) return result;
  const Options& o = index_->options;
  Stopwatch watch;
  const DescribedMap& map = index_->described();
  const Descriptors words = describe(query.graph, map.alphabet, o.walks,
                                     2 * static_cast<std::uint64_t>(o.seed), o.threads);
  timing_ms.emplace_back("descriptors", watch.lap_ms());
  askBudget("the correspondences");
  result.putative = map.index.bestMatches(words, o.match, o.threads);
  timing_ms.emplace_back("matching", watch.lap_ms());
  std::vector<Correspondence> matches = result.putative;
  const std::vector<Eigen::Vector3d>& to = map.walks.positions;
  const std::string gravity = up_known ? o.posterior.gravity : "free";
  while (static_cast<int>(result.poses.size()) < count && matches.size() >= 3) {
    askBudget("the correspondences");
    const std::vector<Correspondence> consistent = consistentCorrespondences(
        query.positions, to, matches, o.consensus.inlier_m, gravity != "free");
    MatchedPose pose = consensusOf(query, to, consistent, matches, gravity, o.consensus);
    if (!pose.found) break;
    pose.consensus_m = consensusValue(query, to, pose);
    std::vector<Correspondence> rest;
    for (const Correspondence& c : matches) {
      if ((pose.T_map_query * query.positions[c.query] - to[c.map]).norm() >
          3 * o.consensus.inlier_m)
        rest.push_back(c);
    }
    matches = std::move(rest);
    result.poses.push_back(std::move(pose));
  }
  std::stable_sort(
      result.poses.begin(), result.poses.end(),
      [](const MatchedPose& a, const MatchedPose& b) { return a.kept.size() > b.kept.size(); });
  inFullGraphs(query, map.walks, result);
  timing_ms.emplace_back("rejection", watch.lap_ms());
  return result;
}

/// The alphabet is that of the query: words with another label have no equal in it.
std::vector<WalkMatches> WalkMatcher::matchUnder(const std::vector<Eigen::Isometry3d>& poses,
                                                 const WalkGraph& query, double reach_m,
                                                 Timings& timing_ms) const {
  std::vector<WalkMatches> results(poses.size());
  for (WalkMatches& result : results) result.poses.emplace_back();
  if (query.graph.empty() || index_->empty()) return results;
  const Options& o = index_->options;
  Stopwatch watch;
  const LabelAlphabet alphabet(query.graph);
  const auto seed = 2 * static_cast<std::uint64_t>(o.seed);
  DescriptorCache of_query(query.graph, alphabet, o.walks, seed);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : query.positions)
    centre += p / static_cast<double>(query.positions.size());
  double radius_m = 0;
  for (const Eigen::Vector3d& p : query.positions)
    radius_m = std::max(radius_m, (p - centre).head<2>().norm());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    askBudget("the correspondences");
    const WalkGraph map = index_->mapAround((poses[i] * centre).head<2>(), radius_m + kMargin_m);
    DescriptorCache of_map(map.graph, alphabet, o.walks, seed + 1);
    Candidates candidates = candidatesUnder(poses[i], query, map, reach_m, of_query, of_map);
    timing_ms.emplace_back("descriptors", watch.lap_ms());
    const std::vector<Correspondence>& best = candidates.best;
    MatchedPose pose =
        consensusOf(query, map.positions, best, best, o.posterior.gravity, o.consensus);
    pose.with_candidates = static_cast<int>(candidates.counts.size());
    pose.kept_if_true = o.places.detection;
    const double inlier_share = std::min(1.0, std::pow(o.consensus.inlier_m / reach_m, 2));
    for (const int count : candidates.counts)
      pose.kept_under_null += 1 - std::pow(1 - inlier_share, count);
    results[i].putative = std::move(candidates.best);
    results[i].poses = {std::move(pose)};
    inFullGraphs(query, map, results[i]);
    timing_ms.emplace_back("rejection", watch.lap_ms());
  }
  return results;
}

}  // namespace xview::match
