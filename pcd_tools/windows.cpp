// SPDX-License-Identifier: BSD-3-Clause
#include "windows.h"

#include <fmt/core.h>

#include <algorithm>

#include "xview/base/error.h"

namespace xview::tools {

std::vector<Window> windowsOf(std::size_t frames, int length, int stride) {
  const auto size = static_cast<std::size_t>(length);
  if (size == 0 || size >= frames) return {{0, frames}};
  const std::size_t step = stride > 0 ? static_cast<std::size_t>(stride) : size;
  std::vector<Window> windows;
  for (std::size_t first = 0; first + size <= frames; first += step)
    windows.push_back({first, first + size});
  return windows;
}

Answer answerFor(const QueryInput& input, const Window& window, const Query& query, Answer answer) {
  answer.input = input.path;
  answer.frames = input.size();
  answer.used_from = std::max(window.first, input.used_from);
  if (!query.jumps.empty()) answer.used_from += query.jumps.back().position;
  answer.last_index = window.last - 1;
  if (input.source) {
    answer.first_frame = input.source->number(window.first);
    answer.last_frame = input.source->number(window.last - 1);
    answer.last_stamp_s = input.source->stamp(window.last - 1);
  }
  return answer;
}

void acceptAtRisk(const std::string& name, double risk, verdict::VerdictOptions& verdict) {
  if (!(risk >= 1e-9 && risk <= 0.5))
    throw UsageError(fmt::format("{} = {}, must be in [1e-9, 0.5]", name, risk));
  verdict.min_confidence = 1 - risk;
}

}  // namespace xview::tools
