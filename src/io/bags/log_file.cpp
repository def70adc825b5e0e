// SPDX-License-Identifier: BSD-3-Clause
// Logs of records: MCAP (mcap.dev/spec) and ROS 1 bags (wiki.ros.org/Bags/Format/2.0).
#include <algorithm>
#include <functional>
#include <map>
#include <mutex>

#include "bag_file.h"
#include "messages.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

constexpr std::uint64_t kLongestHead = 4096;                          ///< of a record [bytes]
constexpr std::uint64_t kLongestConnection = std::uint64_t{1} << 22;  ///< with its definition
constexpr std::size_t kMostChannels = 65536;

/// The file lies: it is refused, not read up to here.
struct Refusal : Error {
  using Error::Error;
};

/// A run of records: a file, or a chunk of one.
struct Records {
  const InputFile& file;
  std::uint64_t size;
  /// So many bytes, all of them within the size.
  std::function<std::string(std::uint64_t position, std::uint64_t bytes)> fetch;

  std::string head(std::uint64_t position, std::uint64_t most = kLongestHead) const {
    return fetch(position, std::min(size - position, most));
  }
};

/// What the two formats have in common.
struct Record {
  enum class Kind { other, type, channel, message, chunk, index, summary, end };
  Kind kind = Kind::other;
  std::uint32_t id = 0;       ///< of the channel, or of the type
  std::uint32_t type_id = 0;  ///< of a channel, if its type is a record of its own
  std::int64_t log_ns = 0;
  std::string name;                  ///< topic or type
  std::string type;                  ///< of a channel, if it has no type_id
  std::string encoding;              ///< of a channel's messages, or of a chunk
  std::uint64_t unpacked = 0;        ///< bytes of a chunk
  std::uint64_t summary = 0;         ///< where channels are repeated; 0 = nowhere
  std::uint64_t data = 0, size = 0;  ///< where its content stands
  std::uint64_t next = 0;            ///< the record behind it

  void place(std::uint64_t begin, std::uint64_t bytes) {
    data = begin;
    size = bytes;
    next = begin + bytes;
  }
};

struct Format {
  std::string_view magic;
  Record (*record)(const Records& records, std::uint64_t position);
  std::size_t entry_bytes;  ///< of an index
  MessageAt (*entry)(Cursor& cursor);
  const char* mend;
};

void requireRoom(const Records& records, std::uint64_t position, std::uint64_t bytes) {
  if (bytes > records.size - position)
    records.file.fail("a record of {} bytes, but {} follow", bytes, records.size - position);
}

// ---- MCAP

Record mcapRecord(const Records& records, std::uint64_t position) {
  const std::string bytes = records.head(position);
  Cursor head(records.file, bytes, Serialization::ros1);
  const auto kind = head.number<std::uint8_t>();
  const auto length = head.number<std::uint64_t>();
  const std::uint64_t begin = position + head.position();
  requireRoom(records, begin, length);
  Record record;
  record.place(begin, length);
  const auto content = [&](std::uint64_t size) {
    const std::uint64_t head_bytes = head.position() - (begin - position);
    if (head_bytes > length || size > length - head_bytes)
      head.fail("a record of {} bytes is too short for its content", length);
    record.data = position + head.position();
    record.size = size;
  };
  switch (kind) {
    case 0:
      head.fail("expected a record, found zeros");
    case 2:
      record.kind = Record::Kind::end;
      record.summary = head.number<std::uint64_t>();
      break;
    case 3:
      record.kind = Record::Kind::type;
      record.id = head.number<std::uint16_t>();
      record.name = head.text();
      break;
    case 4:
      record.kind = Record::Kind::channel;
      record.id = head.number<std::uint16_t>();
      record.type_id = head.number<std::uint16_t>();
      record.name = head.text();
      record.encoding = head.text();
      break;
    case 5:
      record.kind = Record::Kind::message;
      record.id = head.number<std::uint16_t>();
      head.take(4);
      record.log_ns = head.number<std::int64_t>();
      head.take(8);
      content(length - std::min<std::uint64_t>(length, 22));
      break;
    case 6:
      record.kind = Record::Kind::chunk;
      head.take(16);
      record.unpacked = head.number<std::uint64_t>();
      head.take(4);
      record.encoding = head.text();
      content(head.number<std::uint64_t>());
      break;
    case 7:
      record.kind = Record::Kind::index;
      record.id = head.number<std::uint16_t>();
      content(head.number<std::uint32_t>());
      break;
    default:
      break;
  }
  return record;
}

MessageAt mcapEntry(Cursor& cursor) {
  MessageAt entry;
  entry.log_ns = cursor.number<std::int64_t>();
  entry.position = cursor.number<std::uint64_t>();
  return entry;
}

// ---- ROS 1

/// Named values of a header; empty if there is none of that name.
class Fields {
 public:
  Fields(const InputFile& file, std::string_view bytes) : file_(file) {
    Cursor cursor(file, bytes, Serialization::ros1);
    while (cursor.remaining() > 0) {
      const std::string_view field = cursor.take(cursor.number<std::uint32_t>());
      const std::size_t equals = field.find('=');
      if (equals == std::string_view::npos) file.fail("a field without a name");
      values_[field.substr(0, equals)] = field.substr(equals + 1);
    }
  }
  std::string text(std::string_view name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::string() : std::string(found->second);
  }
  template <class T>
  T number(std::string_view name) const {
    const std::string value = text(name);
    if (value.size() != sizeof(T)) file_.fail("a record without its field {}", io::inQuotes(name));
    return storedNumber<T>(value.data(), false);
  }

 private:
  const InputFile& file_;
  std::map<std::string_view, std::string_view> values_;
};

/// Seconds and nanoseconds.
std::int64_t rosTime(std::uint64_t stored) {
  return static_cast<std::int64_t>(stored & 0xFFFFFFFF) * 1000000000 +
         static_cast<std::int64_t>(stored >> 32);
}

Record ros1Record(const Records& records, std::uint64_t position) {
  const std::string bytes = records.head(position);
  Cursor head(records.file, bytes, Serialization::ros1);
  const Fields fields(records.file, head.take(head.number<std::uint32_t>()));
  const auto length = head.number<std::uint32_t>();
  const std::uint64_t begin = position + head.position();
  requireRoom(records, begin, length);
  Record record;
  record.place(begin, length);
  switch (fields.number<std::uint8_t>("op")) {
    case 2:
      record.kind = Record::Kind::message;
      record.id = fields.number<std::uint32_t>("conn");
      record.log_ns = rosTime(fields.number<std::uint64_t>("time"));
      break;
    case 3:
      record.kind = Record::Kind::summary;
      record.summary = fields.number<std::uint64_t>("index_pos");
      break;
    case 4:
      record.kind = Record::Kind::index;
      record.id = fields.number<std::uint32_t>("conn");
      break;
    case 5:
      record.kind = Record::Kind::chunk;
      record.encoding = fields.text("compression");
      if (record.encoding == "none") record.encoding.clear();
      record.unpacked = fields.number<std::uint32_t>("size");
      break;
    case 7: {
      record.kind = Record::Kind::channel;
      record.id = fields.number<std::uint32_t>("conn");
      record.name = fields.text("topic");
      if (length > kLongestConnection) head.fail("a connection of {} bytes", length);
      const std::string description = records.fetch(begin, length);
      record.type = Fields(records.file, description).text("type");
      record.encoding = "ros1";
      break;
    }
    default:
      break;
  }
  return record;
}

MessageAt ros1Entry(Cursor& cursor) {
  MessageAt entry;
  entry.log_ns = rosTime(cursor.number<std::uint64_t>());
  entry.position = cursor.number<std::uint32_t>();
  return entry;
}

constexpr Format kFormats[] = {
    {{"\x89MCAP0\r\n", 8}, mcapRecord, 16, mcapEntry, "mcap recover {} -o MENDED.mcap"},
    {"#ROSBAG V2.0\n", ros1Record, 12, ros1Entry,
     "rosbag reindex {0}, then rosbag fix {0} MENDED.bag"}};

// ---- both

class LogFile final : public BagFile {
 public:
  explicit LogFile(const std::string& path) : BagFile(path), format_(formatOf(file_)) {
    readSummary();
    readRecords(wholeFile(), format_.magic.size(), 0);
    requireNamedOnce();
    for (std::uint32_t i = 0; i < chunks_.size(); ++i) {
      if (!chunks_[i].is_indexed) readChunk(i + 1);
    }
    only_channels_ = true;  // which a file that was not closed has only in its chunks
    for (std::uint32_t i = 0; i < chunks_.size() && unknown_ > 0; ++i) readChunk(i + 1);
    for (auto& [id, channel] : by_id_) {
      if (!isKnown(channel)) channel.messages = {};
      if (!channel.topic.empty()) channels_.push_back(std::move(channel));
    }
    by_id_.clear();
  }

  std::string read(const MessageAt& message, std::uint64_t most_bytes) const override {
    const Records records = message.chunk == 0 ? wholeFile() : chunk(message.chunk);
    if (message.position >= records.size)
      file_.fail("its index says byte {} of {}", message.position, records.size);
    const Record record = format_.record(records, message.position);
    if (record.kind != Record::Kind::message)
      file_.fail("expected a message, found another record");
    if (record.id != message.channel)
      file_.fail("its index says a message of channel {}, found one of channel {}", message.channel,
                 record.id);
    return records.fetch(record.data, std::min(record.size, most_bytes));
  }

 private:
  struct Chunk {
    std::uint64_t data, size, unpacked;
    std::string compression;
    bool is_indexed;
  };
  using Unpacked = std::shared_ptr<const std::string>;

  static const Format& formatOf(InputFile& file) {
    std::string begin(std::min<std::uint64_t>(file.size(), 16), '\0');
    file.readBytes(begin.data(), begin.size());
    for (const Format& format : kFormats) {
      if (begin.compare(0, format.magic.size(), format.magic) == 0) return format;
    }
    file.fail("expected a log that begins with MCAP0 or #ROSBAG V2.0, found {}",
              io::inQuotes(begin));
  }

  std::string fetch(std::uint64_t position, std::uint64_t bytes) const {
    constexpr std::uint64_t kAhead = std::uint64_t{1} << 16;  ///< heads are read one by one [bytes]
    const std::lock_guard<std::mutex> lock(mutex_);
    if (bytes > kLongestHead) return readAt(position, bytes);
    if (position < ahead_from_ || position + bytes > ahead_from_ + ahead_.size()) {
      ahead_ = readAt(position, std::min(kAhead, file_.size() - position));
      ahead_from_ = position;
    }
    return ahead_.substr(position - ahead_from_, bytes);
  }
  std::string readAt(std::uint64_t position, std::uint64_t bytes) const {
    std::string data(static_cast<std::size_t>(bytes), '\0');
    file_.seek(position);
    file_.readBytes(data.data(), data.size());
    return data;
  }

  Records wholeFile() const {
    return {file_, file_.size(),
            [this](std::uint64_t position, std::uint64_t bytes) { return fetch(position, bytes); }};
  }

  /// What is in a chunk: the same file farther on, or what it unpacks to. The last one is kept.
  Records chunk(std::uint32_t number) const {
    const Chunk& chunk = chunks_.at(number - 1);
    if (chunk.compression.empty())
      return {file_, chunk.size, [this, begin = chunk.data](std::uint64_t at, std::uint64_t bytes) {
                return fetch(begin + at, bytes);
              }};
    Unpacked content;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (kept_ == number) content = kept_content_;
    }
    if (!content) {
      content = std::make_shared<const std::string>(
          unpacked(file_, chunk.compression, fetch(chunk.data, chunk.size), chunk.unpacked));
      const std::lock_guard<std::mutex> lock(mutex_);
      kept_ = number;
      kept_content_ = content;
    }
    return {file_, content->size(), [content](std::uint64_t position, std::uint64_t bytes) {
              return content->substr(position, bytes);
            }};
  }

  /// With the channels known from the start, messages that nobody reads need not be remembered.
  void readSummary() {
    constexpr std::uint64_t kFooter = 9 + 20;  ///< the record before the magic, in MCAP
    const std::uint64_t magic = format_.magic.size(), size = file_.size();
    const bool is_mcap = format_.record == mcapRecord;
    if (is_mcap && (size < 2 * magic + kFooter || fetch(size - magic, magic) != format_.magic))
      return;  // it was not closed
    try {
      const Record place = format_.record(wholeFile(), is_mcap ? size - magic - kFooter : magic);
      only_channels_ = true;
      if (place.summary > 0) readRecords(wholeFile(), place.summary, 0);
    } catch (const Error&) {  // what is wrong is said when all of it is read
    }
    notes_.clear();
    chunks_.clear();
    unpacked_ = 0;
    only_channels_ = false;
  }

  /// Up to the end, or to where it is damaged.
  void readRecords(const Records& records, std::uint64_t position, std::uint32_t chunk) {
    try {
      while (position < records.size) {
        const Record record = format_.record(records, position);
        if (record.kind == Record::Kind::end) return;
        take(records, record, {record.log_ns, position, chunk, 0});
        position = record.next;
      }
    } catch (const Refusal&) {
      throw;
    } catch (const Error& problem) {
      if (chunk != 0) throw;
      const std::string what = problem.what();
      notes_.push_back(fmt::format(
          "breaks off at byte {} of {} ({}); what is before is read, to mend it: {}", position,
          records.size, what.substr(std::min(what.size(), file_.path().size() + 2)),
          fmt::format(fmt::runtime(format_.mend), file_.path())));
    }
  }

  void take(const Records& records, const Record& record, const MessageAt& place) {
    switch (record.kind) {
      case Record::Kind::type:
        types_.emplace(record.id, record.name);
        break;
      case Record::Kind::channel:
        describe(channelOf(record.id), record);
        break;
      case Record::Kind::message:
        addMessage(record.id, place);
        break;
      case Record::Kind::chunk:
        if (place.chunk != 0) file_.fail("a chunk within a chunk");
        addChunk(record);
        break;
      case Record::Kind::index:
        readIndex(records, record);
        break;
      default:
        break;
    }
  }

  void addChunk(const Record& record) {
    requireNamedOnce();
    chunks_.push_back({record.data, record.size, record.unpacked, record.encoding, false});
    if (record.encoding.empty()) return;
    const std::uint64_t most = mostUnpacked(file_);
    unpacked_ += std::min(record.unpacked, most + 1);
    if (unpacked_ > most)
      throw Refusal(file_.path(),
                    fmt::format("its first {} chunks say that they unpack to more than {} bytes, "
                                "which are expected at most of a file of {}",
                                chunks_.size(), most, file_.size()));
  }

  Channel& channelOf(std::uint32_t id) {
    const auto [entry, is_new] = by_id_.try_emplace(id);
    if (is_new) ++unknown_;
    if (by_id_.size() > kMostChannels)
      throw Refusal(file_.path(), fmt::format("has more than {} connections", kMostChannels));
    return entry->second;
  }

  void describe(Channel& channel, const Record& record) {
    if (!channel.topic.empty()) return;
    if (!record.name.empty()) --unknown_;
    const auto type = types_.find(record.type_id);
    channel.topic = record.name;
    channel.type = plainType(type == types_.end() ? record.type : type->second);
    channel.serialization = record.encoding == "ros1" ? Serialization::ros1 : Serialization::cdr;
    if (record.encoding != "ros1" && record.encoding != "cdr")
      channel.type += " (" + record.encoding + ")";  // which no reader knows
  }

  void addMessage(std::uint32_t id, const MessageAt& message) {
    if (only_channels_) return;
    Channel& channel = channelOf(id);
    channel.add(message);
    channel.messages.back().channel = id;
    if (!channel.topic.empty() && !isKnown(channel)) channel.messages.clear();
  }

  /// It belongs to the chunk before.
  void readIndex(const Records& records, const Record& record) {
    if (chunks_.empty() || only_channels_) return;
    const std::string bytes = records.fetch(record.data, record.size);
    Cursor cursor(file_, bytes, Serialization::ros1);
    while (cursor.remaining() >= format_.entry_bytes) {
      MessageAt entry = format_.entry(cursor);
      entry.chunk = static_cast<std::uint32_t>(chunks_.size());
      named_.push_back(entry.position);
      addMessage(record.id, entry);
      chunks_.back().is_indexed = true;
    }
  }

  /// By the index of the last chunk.
  void requireNamedOnce() {
    std::sort(named_.begin(), named_.end());
    const auto twice = std::adjacent_find(named_.begin(), named_.end());
    if (twice != named_.end())
      throw Refusal(file_.path(),
                    fmt::format("its index names the message at byte {} of the chunk at byte {} "
                                "twice",
                                *twice, chunks_.back().data));
    named_.clear();
  }

  void readChunk(std::uint32_t number) {
    try {
      readRecords(chunk(number), 0, number);
    } catch (const Refusal&) {
      throw;
    } catch (const Error& problem) {
      throw Error(fmt::format("{}, in the chunk at byte {}; to mend it: {}", problem.what(),
                              chunks_[number - 1].data,
                              fmt::format(fmt::runtime(format_.mend), file_.path())));
    }
  }

  const Format& format_;
  std::vector<Chunk> chunks_;
  std::map<std::uint32_t, std::string> types_;
  std::map<std::uint32_t, Channel> by_id_;
  std::size_t unknown_ = 0;           ///< channels that have no name yet
  std::vector<std::uint64_t> named_;  ///< positions in the index of the last chunk
  std::uint64_t unpacked_ = 0;        ///< what the packed chunks say that they are [bytes]
  bool only_channels_ = false;        ///< messages are passed over
  mutable std::mutex mutex_;          ///< of the file and of what is kept of it
  mutable std::uint32_t kept_ = 0;
  mutable Unpacked kept_content_;
  mutable std::string ahead_;  ///< a piece of the file, read at once
  mutable std::uint64_t ahead_from_ = 0;
};

}  // namespace

std::unique_ptr<BagFile> openLog(const std::string& path) {
  return std::make_unique<LogFile>(path);
}

}  // namespace xview::io
