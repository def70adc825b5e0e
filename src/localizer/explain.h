// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "search/field.h"
#include "xview/localizer.h"

namespace xview {

/// Adds what each BEV sample says about a pose. Map, query and pose are gravity-aligned.
void explainSamples(const BevGrid& map, const Query& query, const search::FieldQuery& in_field,
                    const Eigen::Isometry3d& T_map_query, Explanation& explanation);

/// Adds pairs of vertices that a pose brings together.
void explainVertices(const map::SemanticMap& map, const Query& query,
                     const std::vector<Correspondence>& kept, const Eigen::Isometry3d& T_map_query,
                     Explanation& explanation);

/// All lengths times `factor`.
void scaleLengths(double factor, Explanation& explanation);

/// Turns all positions.
void turn(const Eigen::Quaterniond& R, Explanation& explanation);

}  // namespace xview
