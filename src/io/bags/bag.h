// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <mutex>
#include <new>
#include <set>
#include <tuple>

#include "base/user_text.h"
#include "messages.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"

namespace xview::io {

/// All messages of one name and type, in the order of the files.
struct Topic : Channel {
  Content content = Content::other;

  /// Transforms that hold for ever.
  bool isStatic() const;
};

/// .mcap, .db3, .bag or, while it is recorded, .bag.active.
bool isBagFile(const std::filesystem::path& path);

/// The files of a bag as one. Messages are read one by one, from several threads.
class Bag {
 public:
  explicit Bag(const std::string& path);  ///< throws Error

  const std::string& path() const { return path_; }
  const std::vector<Topic>& topics() const { return topics_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// use(cursor) of the message, or of as much of its beginning.
  template <class Use>
  auto read(const Topic& topic, const MessageAt& message, std::uint64_t most_bytes,
            Use&& use) const {
    const BagFile& file = *files_.at(message.file);
    try {
      const std::string bytes = bytesOf(file, message, most_bytes);
      Cursor cursor(file.file(), bytes, topic.serialization);
      return use(cursor);
    } catch (const std::bad_alloc&) {
      if (BudgetOfThread::current()) throw;  // its bound was reached
      file.file().fail("a message of {} of {:.3f} s needs more memory than there is",
                       printable(topic.topic), 1e-9 * static_cast<double>(message.log_ns));
    } catch (const Error& problem) {
      throw Error(fmt::format(
          "{}, in the message of {} of {:.3f} s ({} {}{}); another --topic or a mended copy may do",
          problem.what(), printable(topic.topic), 1e-9 * static_cast<double>(message.log_ns),
          message.chunk == 0 ? "at" : "chunk",
          message.chunk == 0 ? message.position : message.chunk,
          message.chunk == 0 ? std::string() : fmt::format(", byte {} of it", message.position)));
    }
  }

 private:
  void add(const Channel& channel, Topic& topic) const;
  std::string bytesOf(const BagFile& file, const MessageAt& message,
                      std::uint64_t most_bytes) const;

  std::string path_;
  std::vector<std::unique_ptr<BagFile>> files_;
  std::vector<Topic> topics_;
  std::vector<std::string> notes_;
  using Place = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>;
  mutable std::mutex mutex_;                       ///< of the two that follow
  mutable std::set<Place> seen_;                   ///< large messages that were read as a whole
  mutable std::vector<std::uint64_t> seen_bytes_;  ///< of these, in each file
};

/// In the order of the files, of a bag.
inline bool isBefore(const MessageAt& a, const MessageAt& b) {
  return std::tie(a.file, a.chunk, a.position) < std::tie(b.file, b.chunk, b.position);
}

struct TopicAndMessage {
  const Topic* topic;
  const MessageAt* message;
};
/// The messages of some topics in the order of the file, so that no chunk is unpacked twice.
std::vector<TopicAndMessage> inFileOrder(const std::vector<const Topic*>& topics);

}  // namespace xview::io
