// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <vector>

#include "base/stored_vertices.h"
#include "xview/base/graph.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"
#include "xview/options.h"

namespace xview::match {

/// The graph that walks run on. Surfaces are spaced as in the paper (merge.first_observation_m,
/// first observation kept), because a walk over a fine lattice of road says nothing; objects stay
/// as they are. Edges by radius, of these to the nearest. A graph of image space is spaced already
/// and keeps its edges, so that either space can be matched against the other (paper, section
/// III-B).
struct WalkGraph {
  SemanticGraph graph;
  std::vector<std::uint32_t> source;       ///< per vertex, its number in the full graph
  std::vector<Eigen::Vector3d> positions;  ///< of the vertices
};

WalkGraph walkGraph(const SemanticGraph& graph, const LabelSet& labels, const Options& options);

/// The vertices with these numbers (ascending). Edges of image space among them are kept, others
/// are made anew by walkGraph.
SemanticGraph inducedGraph(const SemanticGraph& graph, const std::vector<std::uint32_t>& numbers);

/// A pose and the correspondences that agree on it, in numbers of the full graphs.
struct MatchedPose {
  bool found = false;  ///< sample consensus has a pose; the other fields hold in any case
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Correspondence> kept;
  /// Tightest tolerance at which more than six vertices agree with the pose, s of the paper [m];
  /// not asked under a hypothesis.
  double consensus_m = std::numeric_limits<double>::infinity();
  /// Under a hypothesis: how many query vertices had a candidate at all, and how many of these
  /// would keep one at a wrong place, where candidates lie anywhere within reach.
  int with_candidates = 0;
  double kept_under_null = 0;
  double kept_if_true = 0;  ///< chance that one of them keeps a candidate at the true place
};

struct WalkMatches {
  std::vector<Correspondence> putative;  ///< k best map vertices per query vertex
  std::vector<MatchedPose> poses;        ///< most correspondences first
};

/// X-View's chain: descriptors of walks, k best partners, sample consensus of PCL, SVD (paper,
/// sections III-D to III-F), with the whole map or the surroundings of a hypothesis as the place.
class WalkMatcher {
 public:
  /// `stored`: the vertices of the map, if the graph does not hold them; null otherwise. Both must
  /// outlive the matcher.
  WalkMatcher(const SemanticGraph& map, const StoredVertices* stored, const LabelSet& labels,
              const Options& options);
  ~WalkMatcher();

  /// The query as the walks see it.
  WalkGraph queryGraph(const SemanticGraph& query) const;

  /// The paper: up to `count` poses anywhere in the map, each from the matches that others left
  /// over. Describes the whole map at the first call. `up_known`: poses turn about z only.
  WalkMatches matchEverywhere(const WalkGraph& query, int count, bool up_known,
                              Timings& timing_ms) const;

  /// The same where hypotheses put the query: partners of a vertex are map vertices of its class
  /// within `reach_m` of its place. Descriptors rank this handful, which they can do in noise;
  /// hundreds of vertices of one class in a neighbourhood they cannot. Each has one pose, found or
  /// not.
  std::vector<WalkMatches> matchUnder(const std::vector<Eigen::Isometry3d>& poses,
                                      const WalkGraph& query, double reach_m,
                                      Timings& timing_ms) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace xview::match
