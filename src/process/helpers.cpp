// SPDX-License-Identifier: BSD-3-Clause
#include "process/helpers.h"

#include <exception>

namespace xview {
namespace {

struct Sharing {
  std::mutex mutex;  ///< who holds it talks to the helpers
  Helpers* helpers = nullptr;
  std::uint64_t generation = 0;
  std::vector<const FrameSource*> recordings;
};
Sharing& sharing() {
  static Sharing one;
  return one;
}

}  // namespace

void shareWork(Helpers* helpers) {
  const std::lock_guard<std::mutex> lock(sharing().mutex);
  sharing().helpers = helpers;
  ++sharing().generation;
}

SharedRecordings::SharedRecordings(const std::vector<const FrameSource*>& sources) {
  const std::lock_guard<std::mutex> lock(sharing().mutex);
  sharing().recordings = sources;
}

SharedRecordings::~SharedRecordings() {
  const std::lock_guard<std::mutex> lock(sharing().mutex);
  sharing().recordings.clear();
}

Conversation::Conversation() : lock_(sharing().mutex, std::try_to_lock) {
  if (lock_ && sharing().helpers)
    unanswered_.resize(static_cast<std::size_t>(sharing().helpers->count()));
}

Conversation::Conversation(const std::vector<const FrameSource*>& recordings) : Conversation() {
  if (!lock_ || recordings == sharing().recordings) return;
  unanswered_.clear();
  lock_.unlock();
}

Conversation::~Conversation() {
  for (std::size_t i = 0; i < helpers(); ++i) {
    while (unanswered_[i] > 0) {
      try {
        answerOf(i);
      } catch (const std::exception&) {
        // What was asked for is not wanted any more; a helper that is gone is met by the next
        // request.
      }
    }
  }
}

std::uint64_t Conversation::generation() const { return sharing().generation; }

void Conversation::ask(std::size_t helper, const std::string& request) {
  sharing().helpers->send(static_cast<int>(helper), request);
  ++unanswered_.at(helper);
}

std::string Conversation::answerOf(std::size_t helper) {
  --unanswered_.at(helper);
  return sharing().helpers->receive(static_cast<int>(helper));
}

}  // namespace xview
