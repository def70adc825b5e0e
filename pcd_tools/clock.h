// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace xview::tools {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace xview::tools
