// SPDX-License-Identifier: BSD-3-Clause
#include "request_metrics.h"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

namespace xview::tools {

void Metrics::add(const std::string& route, int status, double seconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++requests_[{route, status}];
  Latencies& latencies = latencies_[route];
  ++latencies.count;
  latencies.sum_s += seconds;
  latencies.last_s.push_back(seconds);
  if (latencies.last_s.size() > kLast) latencies.last_s.pop_front();
}

void Metrics::addJump() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++jumps_;
}

std::string Metrics::text(std::size_t connections, int exchanges, int maps) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string text = "# TYPE xview_requests_total counter\n";
  for (const auto& [key, count] : requests_)
    text += fmt::format("xview_requests_total{{route=\"{}\",status=\"{}\"}} {}\n", key.first,
                        key.second, count);
  text += "# TYPE xview_latency_seconds summary\n";
  for (const auto& [route, latencies] : latencies_) {
    std::vector<double> sorted(latencies.last_s.begin(), latencies.last_s.end());
    std::sort(sorted.begin(), sorted.end());
    for (const double q : {0.5, 0.99})
      text +=
          fmt::format("xview_latency_seconds{{route=\"{}\",quantile=\"{}\"}} {:.6f}\n", route, q,
                      sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))]);
    text += fmt::format(
        "xview_latency_seconds_sum{{route=\"{0}\"}} {1:.6f}\n"
        "xview_latency_seconds_count{{route=\"{0}\"}} {2}\n",
        route, latencies.sum_s, latencies.count);
  }
  return text + fmt::format(
                    "# TYPE xview_jumps_total counter\nxview_jumps_total {}\n"
                    "# TYPE xview_connections gauge\nxview_connections {}\n"
                    "# TYPE xview_map_exchanges_total counter\nxview_map_exchanges_total {}\n"
                    "# TYPE xview_maps_in_memory gauge\nxview_maps_in_memory {}\n",
                    jumps_, connections, exchanges, maps);
}

}  // namespace xview::tools
