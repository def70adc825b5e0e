// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/search/field.h"
#include "xview/types/option_field.h"

namespace xview::search {

struct SearchOptions {
  int hypotheses = 5;       ///< distinct places that are reported
  std::string likelihoods;  ///< file of xview learn; empty = what the program comes with
  double cell_m = 2;        ///< of the exhaustive search over BEV grids, taken as the nearest
                            ///< power of two of bev.cell_m; twice that at first in
                            ///< large maps. Larger is faster and less sure
  double detection = 0.62;  ///< bare graphs: chance that a query finds an object again
  double sigma_m = 0.9;     ///< bare graphs: of an object's position, map and query together
};

template <class Visitor>
void visit(SearchOptions& o, Visitor&& field) {
  field("hypotheses", o.hypotheses, Range{1, 1000}, "distinct places reported");
  field("likelihoods", o.likelihoods, "file of xview learn; empty = built in");
  field("cell_m", o.cell_m, Range{0.5, 8}, "cells of the exhaustive (x, y, yaw) search [m]");
  field("detection", o.detection, Range{0.05, 0.99},
        "bare graphs: chance that a query finds an object of the map again");
  field("sigma_m", o.sigma_m, Range{0.05, 20},
        "bare graphs: position error of objects, map and query together [m]");
}

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
