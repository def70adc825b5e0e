// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "answer.h"
#include "inputs.h"
#include "verdict/verdict.h"

namespace xview::tools {

/// A recording shorter than a window is one window. `length`: frames per window, 0 = all;
/// `stride`: frames from one start to the next, 0 = as the length.
std::vector<Window> windowsOf(std::size_t frames, int length, int stride);

/// What identifies the answer to a window, of which the query was made. `answer` holds what all
/// answers of the run share.
Answer answerFor(const QueryInput& input, const Window& window, const Query& query, Answer answer);

/// Accepted is what is wrong with at most this chance. Throws UsageError that calls it `name`.
void acceptAtRisk(const std::string& name, double risk, verdict::VerdictOptions& verdict);

/// Path length at the end of a recording of one piece that is the query [m]: of 1 % drift little
/// more than a metre, and more than any place needs.
constexpr double kLastMetres = 150;

}  // namespace xview::tools
