// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "localizer/query_check.h"
#include "map/common_detail.h"
#include "match/walk_matching.h"
#include "search/search.h"
#include "xview/localizer.h"

namespace xview {

/// The places where a query may be, in upright frames and metres of the map.
struct Candidates {
  Proposer by = Proposer::search;
  std::unique_ptr<const search::FieldQuery> in_field;  ///< null if no pose can be scored
  std::vector<search::PlaceHypothesis> places;         ///< best first
  std::size_t to_register = 0;              ///< how many of the first places are to be registered
  std::vector<match::WalkMatches> matches;  ///< of the first few places
  double second_best_score = 0;  ///< of the best place outside of the priors or in another frame
};

/// Places that score about as well as the best one, a handful at most.
std::size_t countClose(const std::vector<search::PlaceHypothesis>& places);
/// Takes the best place around a pose that was found otherwise among those that are registered.
void addProposed(const Eigen::Isometry3d& T_map_query, Candidates& found);
/// Makes the place around a pose that was found otherwise the first one, whatever it scores.
void putFirst(const Eigen::Isometry3d& T_map_query, Candidates& found);
/// What speaks for a place of a search.
PlaceEvidence evidenceOf(const search::PlaceHypothesis& place);

/// What tells how well a pose of a query fits a map: surfaces and objects of the bird's-eye views
/// if both have them, else their graphs. Map and options must outlive it.
class MapFields {
 public:
  /// `with_views`: false leaves the view of the map aside. `detail`: see surfaceFieldOf().
  MapFields(const map::SemanticMap& map, const Options& options, bool with_views,
            const map::CommonDetail& detail);

  bool isView(const Query& query) const { return surfaces_ && !query.bev.known.empty(); }
  const search::Field* surfaces() const { return surfaces_.get(); }  ///< null without views
  /// The query in the field that is made for it, at the first query of its kind.
  std::unique_ptr<const search::FieldQuery> prepare(const Query& query) const;

 private:
  const map::SemanticMap& map_;
  const Options& options_;
  std::unique_ptr<const search::Field> surfaces_;
  mutable std::once_flag objects_made_;
  mutable std::unique_ptr<const search::Field> objects_;
};

/// Who says where a query may be.
class PlaceProposer {
 public:
  virtual ~PlaceProposer() = default;
  /// Places of an upright query that satisfy all priors, best first; what it took is added to the
  /// times. Thread-safe.
  virtual Candidates propose(const Query& query, const Priors& priors,
                             Timings& timing_ms) const = 0;
};

/// What a proposer is made of. All of it outlives the proposer.
struct ProposerInputs {
  const map::SemanticMap& map;
  const MapFields& fields;
  const match::WalkMatcher& walks;
  const Options& options;
};

/// A value of Options::method.
struct Method {
  const char* name;
  bool scores_poses;      ///< the fields of map and query say how well any pose fits
  bool matches_vertices;  ///< X-View's chain pairs the vertices at the best places
  std::unique_ptr<const PlaceProposer> (*make)(const ProposerInputs& inputs);
};
const Method& methodOf(const Options& options);

/// An exhaustive search over position and heading (search::search).
std::unique_ptr<const PlaceProposer> makeSearchProposer(const ProposerInputs& inputs);
/// X-View: the whole map is the one place in which partners of the vertices are looked for.
std::unique_ptr<const PlaceProposer> makeWalkProposer(const ProposerInputs& inputs);

}  // namespace xview
