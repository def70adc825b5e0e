// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "cursor.h"

namespace xview::io {

/// Where a message stands in a bag; of one file the order is that of reading from front to back.
struct MessageAt {
  std::int64_t log_ns = 0;     ///< when it was recorded [ns]
  std::uint64_t position = 0;  ///< of its record in the file or in its chunk; its row in a database
  std::uint32_t chunk = 0;     ///< the first is 1; 0 = in none
  std::uint32_t file = 0;      ///< of a bag of several
  std::uint32_t channel = 0;   ///< that wrote it, as its record in a log says
};

/// What one publisher or topic wrote into a file.
struct Channel {
  std::string topic;
  std::string type;  ///< "sensor_msgs/PointCloud2", as ROS 1 writes it
  Serialization serialization = Serialization::cdr;
  std::uint64_t count = 0;
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();  ///< when it was recorded
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  std::vector<MessageAt> messages;  ///< only if messages of this type can be read (isKnown)

  void add(const MessageAt& message) {
    ++count;
    first_ns = std::min(first_ns, message.log_ns);
    last_ns = std::max(last_ns, message.log_ns);
    messages.push_back(message);
  }
};

/// What the messages of a file may be together once they are unpacked, and those of one chunk
/// [bytes]: recordings do not become smaller than a hundredth.
inline std::uint64_t mostUnpacked(const InputFile& file) {
  constexpr std::uint64_t kFree = std::uint64_t{32} << 20, kRatio = 100;
  return kFree + kRatio * file.size();
}
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 30;  ///< [bytes]

/// As many bytes as a message has.
constexpr std::uint64_t kWhole = std::numeric_limits<std::uint64_t>::max();

/// One file with messages: what is where. Messages are read one by one, from several threads.
class BagFile {
 public:
  explicit BagFile(const std::string& path) : file_(path) {}
  virtual ~BagFile() = default;
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  const InputFile& file() const { return file_; }
  std::vector<Channel> takeChannels() { return std::move(channels_); }
  const std::vector<std::string>& notes() const { return notes_; }
  /// The message, or as much of its beginning. Throws Error.
  virtual std::string read(const MessageAt& message, std::uint64_t most_bytes) const = 0;

 protected:
  mutable InputFile file_;
  std::vector<Channel> channels_;
  std::vector<std::string> notes_;  ///< where the file breaks off
};

/// MCAP, ROS 1 bags of version 2.0: logs of records, many of them in compressed chunks. They are
/// walked record by record, over what chunks hold if an index of it follows; so a file that was
/// not closed is read up to where it breaks off, which is said in its notes. Throws Error.
std::unique_ptr<BagFile> openLog(const std::string& path);
/// SQLite databases of rosbag2. Throws Error.
std::unique_ptr<BagFile> openDatabase(const std::string& path);

/// A chunk as it was before "lz4", "zstd" or "bz2" made it small, or as much of its beginning.
/// `bytes` is what all of it must become, mostUnpacked() at most; no more memory is taken than what
/// has been unpacked needs. Throws Error.
std::string unpacked(const InputFile& file, const std::string& compression,
                     const std::string& packed, std::uint64_t bytes,
                     std::uint64_t most_bytes = kWhole);

/// Whether a message was made small on its own, as rosbag2 does if asked, with "zstd".
bool isPackedMessage(const std::string& bytes);
/// As much of its beginning. The first kPackedHead bytes are enough for kHeadBytes.
std::string unpackedMessage(const InputFile& file, const std::string& packed,
                            std::uint64_t most_bytes);
constexpr std::uint64_t kPackedHead = std::uint64_t{1}
                                      << 18;  ///< more than a block of zstd [bytes]

}  // namespace xview::io
