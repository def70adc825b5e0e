// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "xview/types/helpers.h"

namespace xview {

/// What a request begins with (MessageWriter).
enum class HelperTask : std::uint32_t { scan, frame };

/// The helpers of this process, for whoever came first; for others there are none as long as it
/// lives.
class Conversation {
 public:
  Conversation();
  /// There are helpers only if these are the SharedRecordings.
  explicit Conversation(const std::vector<const FrameSource*>& recordings);
  ~Conversation();  ///< what is not answered yet is waited for
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  std::size_t helpers() const { return unanswered_.size(); }
  /// Differs from that of all helpers that were shared with before.
  std::uint64_t generation() const;
  void ask(std::size_t helper, const std::string& request);
  /// To the first request that is not answered yet.
  std::string answerOf(std::size_t helper);

 private:
  std::unique_lock<std::mutex> lock_;
  std::vector<int> unanswered_;  ///< requests of each helper
};

}  // namespace xview
