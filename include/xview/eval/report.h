// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/eval/evaluation.h"

namespace xview {

// The contents of the files that describe an evaluation; whoever calls writes them.

std::string evaluationTable(const Evaluation& evaluation);  ///< for people, some lines of text
std::string resultsCsv(const std::vector<ScoredQuery>& queries);  ///< one line per query
std::string precisionRecallCsv(const Evaluation& evaluation);     ///< one line per threshold
std::string successCsv(
    const std::vector<ScoredQuery>& queries);              ///< share of queries over the distance
std::string evaluationJson(const Evaluation& evaluation);  ///< all numbers; unknown ones are null

/// A point of the map in the report's 3-D view, with its colour as 0xRRGGBB.
struct ReportPoint {
  float x = 0, y = 0, z = 0;
  unsigned rgb = 0x808080;
};

/// One page without any outside reference: the table, both curves, the list of queries, and a 3-D
/// view (turn, shift and zoom with the mouse) of the map with the true and the found position of
/// each query.
std::string reportHtml(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries,
                       const std::vector<ReportPoint>& map);

}  // namespace xview
