// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace xview {

/// Milliseconds of wall time since construction or the last lap.
class Stopwatch {
 public:
  double lap_ms() {
    const auto now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace xview
