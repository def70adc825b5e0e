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

}  // namespace xview
