// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "answer.h"
#include "xview/explanation.h"

namespace xview::tools {

/// Throws UsageError if `path` names one file although there may be several queries, Error if that
/// file cannot be written. Empty is fine.
void checkExplanationPath(const std::string& path, bool is_one_query);

/// FILE.csv and FILE.ply, or if `path` has no ending .csv, QUERY_FIRST-LAST.csv and .ply in that
/// folder, which is made if missing. `query` counts the queries of a run.
void writeExplanation(const std::string& path, int query, const Answer& answer,
                      const Explanation& explanation);

}  // namespace xview::tools
