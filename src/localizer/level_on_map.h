// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "search/field.h"
#include "xview/localizer.h"

namespace xview {

/// What a search asks of a query; the query must outlive it.
search::Observation observationOf(const Query& query);

/// A query turned so that its ground lies on that of the map.
struct LevelledQuery {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< p_levelled = turn * p_given
  Query query;
  std::unique_ptr<search::FieldQuery> in_field;
  Eigen::Isometry3d T_map_query;  ///< of the levelled query, gravity-aligned
  double up_sigma_rad = 0;
};

/// Once the place of a query is known, ground that it has in common with the map tells how far off
/// level it is. `up_sigma_rad` is how well its up was measured; 0 if it is up by the word of
/// whoever made the frame, which is trusted to options.refine.tilt_sigma_deg unless ground clearly
/// contradicts. Null if it is level already, or too little ground is common.
std::unique_ptr<LevelledQuery> levelOnMap(const search::Field& field,
                                          const search::FieldQuery& in_field, const Query& query,
                                          const Eigen::Isometry3d& T_map_query, double up_sigma_rad,
                                          const Options& options);

}  // namespace xview
