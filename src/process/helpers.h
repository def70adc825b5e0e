// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace xview {

class FrameSource;

/// Other processes on machines of the same kind, each with a Helper, which do a part of what this
/// process has to do: they scan parts of large maps and preprocess frames of recordings that they
/// have, too. Called from one thread at a time.
class Helpers {
 public:
  virtual ~Helpers() = default;
  virtual int count() const = 0;
  /// Must not wait for the helper to have worked. Throws Error if the helper is gone.
  virtual void send(int helper, const std::string& request) = 0;
  /// The answer to the first request that is not answered yet. Throws Error if the helper is gone.
  virtual std::string receive(int helper) = 0;
};

/// Sets the helpers of later calls; null ends sharing. `helpers` must outlive all computations, and
/// none may run meanwhile. Results are the same for any number of helpers.
void shareWork(Helpers* helpers);

/// As long as it lives, each Helper can open the same recordings, in this order, if there are
/// helpers.
class SharedRecordings {
 public:
  explicit SharedRecordings(const std::vector<const FrameSource*>& sources);
  ~SharedRecordings();
  SharedRecordings(const SharedRecordings&) = delete;
  SharedRecordings& operator=(const SharedRecordings&) = delete;
};

/// What a request begins with (MessageWriter).
enum class HelperTask : std::uint32_t { scan, frame };

/// Exclusive use of the helpers of this process: meanwhile, other Conversations have none.
class Conversation {
 public:
  Conversation();
  /// There are helpers only if these are the SharedRecordings.
  explicit Conversation(const std::vector<const FrameSource*>& recordings);
  ~Conversation();  ///< what is not answered yet is waited for
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  std::size_t helpers() const { return unanswered_.size(); }
  /// Number of the set of helpers: each call of shareWork() has another.
  std::uint64_t generation() const;
  void ask(std::size_t helper, const std::string& request);
  /// The answer to the first request that is not answered yet.
  std::string answerOf(std::size_t helper);

 private:
  std::unique_lock<std::mutex> lock_;
  std::vector<int> unanswered_;  ///< requests of each helper
};

}  // namespace xview
