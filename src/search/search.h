// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "search/field.h"
#include "xview/options.h"

namespace xview::search {

struct SearchResult {
  /// Distinct places (samePlace) within the priors, best first. The best options.hypotheses of them
  /// are described in full, the others have a pose in the plane and a score only.
  std::vector<PlaceHypothesis> places;
  /// Score of the best place just outside of what the priors allow: better than all inside, it
  /// refutes them. 0 if there is none.
  double outside = 0;
  int poses = 0;             ///< distinct poses that were tried
  std::size_t vertices = 0;  ///< samples or vertices of the query that took part
};

/// Where does the query fit? Exhaustive over position and heading within the priors, all of which
/// must hold: `near` for the focus of the query, `heading` for the yaw of its frame. Of a query too
/// wide for that, dense parts are searched for, and the poses found must explain the rest. Nothing
/// is found if nothing agrees (empty map or query, no common class). The result is the same for any
/// number of threads.
SearchResult search(const FieldQuery& query, const std::vector<PlacePrior>& priors,
                    const SearchOptions& options, int threads);

/// What the narrowest circle and heading of the priors of a point say about another one, `lever`
/// away from it in the frame of the query. The circle is shifted by the lever if the heading is
/// known, else only widened.
PlacePrior priorOfPoint(const std::vector<PlacePrior>& priors, const Eigen::Vector2d& lever);

}  // namespace xview::search
