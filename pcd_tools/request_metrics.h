// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace xview::tools {

/// Counts and the last latencies, for /metrics.
class Metrics {
 public:
  void add(const std::string& route, int status, double seconds);
  void addJump();  ///< of a robot that is followed
  std::string text(std::size_t connections, int exchanges, int maps) const;

 private:
  static constexpr std::size_t kLast = 4096;
  struct Latencies {
    std::uint64_t count = 0;
    double sum_s = 0;
    std::deque<double> last_s;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> requests_;
  std::map<std::string, Latencies> latencies_;
  std::uint64_t jumps_ = 0;
};

}  // namespace xview::tools
