// SPDX-License-Identifier: BSD-3-Clause
#include "support/bags.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "support/test_data.h"

namespace xview::test {
namespace {

template <class T>
std::string le(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string lengthAnd(const std::string& text) {
  return le(static_cast<std::uint32_t>(text.size())) + text;
}

/// "sensor_msgs/msg/PointCloud2"
std::string ros2Type(const std::string& type) {
  const std::size_t slash = type.find('/');
  return type.substr(0, slash) + "/msg" + type.substr(slash);
}

/// Topics by number, in the order in which they come.
class Numbers {
 public:
  explicit Numbers(const std::vector<BagMessage>& messages) {
    for (const BagMessage& message : messages) {
      if (numbers_.emplace(message.topic, numbers_.size()).second) first_.push_back(&message);
    }
  }
  std::uint32_t of(const BagMessage& message) const {
    return static_cast<std::uint32_t>(numbers_.at(message.topic));
  }
  const std::vector<const BagMessage*>& first() const { return first_; }

 private:
  std::map<std::string, std::size_t> numbers_;
  std::vector<const BagMessage*> first_;
};

/// Index entries of each topic.
using Entries = std::map<std::uint32_t, std::string>;

// ---- MCAP

std::string mcapRecord(int kind, const std::string& content) {
  return le(static_cast<std::uint8_t>(kind)) + le(std::uint64_t{content.size()}) + content;
}

std::string mcapChannel(std::uint32_t number, const BagMessage& message, const LogShape& shape) {
  const auto id = static_cast<std::uint16_t>(number);
  const std::string type = shape.encoding == "cdr" ? ros2Type(message.type) : message.type;
  return mcapRecord(3, le(static_cast<std::uint16_t>(id + 1)) + lengthAnd(type) +
                           lengthAnd(shape.encoding + "msg") + lengthAnd("its definition")) +
         mcapRecord(4, le(id) + le(static_cast<std::uint16_t>(id + 1)) + lengthAnd(message.topic) +
                           lengthAnd(shape.encoding) + lengthAnd(""));
}

// ---- ROS 1

std::string field(const std::string& name, const std::string& value) {
  return lengthAnd(name + "=" + value);
}

std::string rosRecord(const std::string& header, const std::string& data) {
  return lengthAnd(header) + lengthAnd(data);
}

std::string rosTime(std::int64_t ns) {
  return le(static_cast<std::uint32_t>(ns / 1000000000)) +
         le(static_cast<std::uint32_t>(ns % 1000000000));
}

std::string rosConnection(std::uint32_t number, const BagMessage& message) {
  return rosRecord(field("op", "\x07") + field("conn", le(number)) + field("topic", message.topic),
                   field("message_definition", std::string(5000, 'd')) +
                       field("topic", message.topic) + field("type", message.type) +
                       field("md5sum", std::string(32, '0')));
}

}  // namespace

std::string packed(const std::string& compression, const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 8 + 4096, '\0');
  std::size_t size = out.size();
  if (compression.empty()) return bytes;
  if (compression == "zstd") {
    size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1);
  } else if (compression == "lz4") {
    size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  } else {
    auto count = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &count, const_cast<char*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), 1, 0, 0);
    size = count;
  }
  out.resize(size);
  return out;
}

MessageWriter::MessageWriter(Wire wire) : wire_(wire) {
  if (wire == Wire::ros1) return;
  bytes_ = std::string("\0\0\0\0", 4);
  bytes_[1] = wire == Wire::cdr_little ? 1 : 0;
  origin_ = 4;
}

MessageWriter& MessageWriter::put(const char* bytes, std::size_t count, bool reversed) {
  std::string piece(bytes, count);
  if (reversed) std::reverse(piece.begin(), piece.end());
  bytes_ += piece;
  return *this;
}

void MessageWriter::align(std::size_t bytes) {
  while (wire_ != Wire::ros1 && (bytes_.size() - origin_) % bytes != 0) bytes_ += '\0';
}

MessageWriter& MessageWriter::text(const std::string& text) {
  const std::string content = wire_ == Wire::ros1 ? text : text + '\0';
  return number(static_cast<std::uint32_t>(content.size())).raw(content);
}

MessageWriter& MessageWriter::header(double stamp_s, const std::string& frame) {
  const double whole = std::floor(stamp_s);
  if (wire_ == Wire::ros1) number(std::uint32_t{7});
  number(static_cast<std::uint32_t>(whole));
  number(static_cast<std::uint32_t>(std::lround(1e9 * (stamp_s - whole))));
  return text(frame);
}

MessageWriter& MessageWriter::pose(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  for (int i = 0; i < 3; ++i) number(T.translation()[i]);
  for (int i = 0; i < 4; ++i) number(q.coeffs()[i]);
  return *this;
}

std::string cloudMessage(Wire wire, double stamp_s, const std::string& frame,
                         const CloudLayout& layout, const std::string& data) {
  MessageWriter writer(wire);
  writer.header(stamp_s, frame).number(layout.height).number(layout.width);
  writer.number(static_cast<std::uint32_t>(layout.fields.size()));
  for (const CloudField& field : layout.fields)
    writer.text(field.name).number(field.offset).number(field.type).number(std::uint32_t{1});
  writer.number(static_cast<std::uint8_t>(layout.big_endian)).number(layout.point_bytes);
  writer.number(layout.line_bytes > 0 ? layout.line_bytes : layout.width * layout.point_bytes);
  writer.number(static_cast<std::uint32_t>(data.size())).raw(data);
  return writer.number(std::uint8_t{1}).bytes();
}

std::string labelledCloudMessage(Wire wire, double stamp_s, const std::string& frame,
                                 const std::vector<Eigen::Vector4f>& points) {
  CloudLayout layout{{{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"label", 12, 6}}, 16};
  layout.width = static_cast<std::uint32_t>(points.size());
  std::string data;
  for (const Eigen::Vector4f& point : points)
    data += le(point[0]) + le(point[1]) + le(point[2]) + le(static_cast<std::uint32_t>(point[3]));
  return cloudMessage(wire, stamp_s, frame, layout, data);
}

std::string livoxMessage(Wire wire, double stamp_s, const std::string& frame,
                         const std::vector<Eigen::Vector3f>& points) {
  MessageWriter writer(wire);
  const auto count = static_cast<std::uint32_t>(points.size());
  writer.header(stamp_s, frame).number(std::uint64_t{12345}).number(count);
  writer.number(std::uint8_t{1}).raw(std::string(3, '\0')).number(count);
  for (const Eigen::Vector3f& point : points) {
    writer.number(std::uint32_t{99}).number(point.x()).number(point.y()).number(point.z());
    writer.raw("abc");
  }
  return writer.bytes();
}

std::string odometryMessage(Wire wire, double stamp_s, const std::string& frame,
                            const std::string& child, const Eigen::Isometry3d& T) {
  MessageWriter writer(wire);
  writer.header(stamp_s, frame).text(child).pose(T);
  for (int i = 0; i < 36 + 6 + 36; ++i) writer.number(0.0);
  return writer.bytes();
}

std::string transformsMessage(Wire wire, const std::vector<Transform>& transforms) {
  MessageWriter writer(wire);
  writer.number(static_cast<std::uint32_t>(transforms.size()));
  for (const Transform& transform : transforms)
    writer.header(transform.stamp_s, transform.frame).text(transform.child).pose(transform.T);
  return writer.bytes();
}

std::string cameraInfoMessage(Wire wire, const std::string& frame, std::uint32_t width,
                              std::uint32_t height, double f, const ImagePart& part,
                              const std::string& lens, double distortion) {
  MessageWriter writer(wire);
  writer.header(0, frame).number(height).number(width).text(lens).number(std::uint32_t{5});
  for (int i = 0; i < 5; ++i) writer.number(distortion);
  for (const double value : {f, 0.0, 0.5 * width, 0.0, f, 0.5 * height, 0.0, 0.0, 1.0})
    writer.number(value);
  for (int i = 0; i < 9 + 12; ++i) writer.number(0.0);
  writer.number(part.binning).number(part.binning).number(part.x).number(part.y);
  writer.number(part.height).number(part.width).number(std::uint8_t{0});
  return writer.bytes();
}

std::string mcapBytes(const std::vector<BagMessage>& messages, const LogShape& shape) {
  const std::string magic("\x89MCAP0\r\n", 8);
  const Numbers numbers(messages);
  std::string file = magic + mcapRecord(1, lengthAnd("ros2") + lengthAnd("test"));
  std::string chunk, channels;
  Entries entries;
  std::vector<bool> known(numbers.first().size());
  const auto finishChunk = [&] {
    if (chunk.empty()) return;
    if (!shape.has_chunks) {
      file += chunk;
    } else {
      const std::string content = packed(shape.compression, chunk);
      file += mcapRecord(6, le(std::uint64_t{0}) + le(std::uint64_t{1}) +
                                le(std::uint64_t{chunk.size()}) + le(std::uint32_t{0}) +
                                lengthAnd(shape.compression) + le(std::uint64_t{content.size()}) +
                                content);
      for (const auto& [id, list] : entries) {
        if (shape.has_indices)
          file += mcapRecord(7, le(static_cast<std::uint16_t>(id)) + lengthAnd(list));
      }
    }
    chunk.clear();
    entries.clear();
  };
  std::size_t in_chunk = 0;
  for (const BagMessage& message : messages) {
    const std::uint32_t number = numbers.of(message);
    if (!known[number]) {
      channels += mcapChannel(number, message, shape);
      chunk += mcapChannel(number, message, shape);
    }
    known[number] = true;
    entries[number] += le(message.log_ns) + le(std::uint64_t{chunk.size()});
    chunk += mcapRecord(5, le(static_cast<std::uint16_t>(number)) + le(std::uint32_t{0}) +
                               le(message.log_ns) + le(message.log_ns) + message.bytes);
    if (++in_chunk % shape.chunk_messages == 0) finishChunk();
  }
  finishChunk();
  if (!shape.is_closed) return file;
  file += mcapRecord(15, le(std::uint32_t{0}));
  const std::uint64_t summary = file.size();
  return file + channels +
         mcapRecord(2, le(summary) + le(std::uint64_t{0}) + le(std::uint32_t{0})) + magic;
}

std::string rosBagBytes(const std::vector<BagMessage>& messages, const LogShape& shape) {
  const Numbers numbers(messages);
  std::uint32_t chunks = 0;
  const auto begin = [&](std::uint64_t index) {
    const std::string header =
        field("op", "\x03") + field("index_pos", le(index)) +
        field("conn_count", le(static_cast<std::uint32_t>(numbers.first().size()))) +
        field("chunk_count", le(chunks));
    return "#ROSBAG V2.0\n" + rosRecord(header, std::string(4096 - 8 - header.size(), ' '));
  };
  std::string file = begin(0), chunk, connections, chunk_infos;
  Entries entries;
  std::int64_t first_ns = 0, last_ns = 0;  // of the chunk
  std::map<std::uint32_t, std::uint32_t> counts;
  std::vector<bool> known(numbers.first().size());
  const auto finishChunk = [&] {
    if (chunk.empty()) return;
    std::string counted;
    for (const auto& [id, count] : counts) counted += le(id) + le(count);
    chunk_infos +=
        rosRecord(field("op", "\x06") + field("ver", le(std::uint32_t{1})) +
                      field("chunk_pos", le(std::uint64_t{file.size()})) +
                      field("start_time", rosTime(first_ns)) + field("end_time", rosTime(last_ns)) +
                      field("count", le(static_cast<std::uint32_t>(counts.size()))),
                  counted);
    ++chunks;
    file +=
        rosRecord(field("op", "\x05") +
                      field("compression", shape.compression.empty() ? "none" : shape.compression) +
                      field("size", le(static_cast<std::uint32_t>(chunk.size()))),
                  packed(shape.compression, chunk));
    for (const auto& [id, list] : entries)
      file += rosRecord(field("op", "\x04") + field("ver", le(std::uint32_t{1})) +
                            field("conn", le(id)) + field("count", le(counts[id])),
                        list);
    chunk.clear();
    entries.clear();
    counts.clear();
  };
  std::size_t in_chunk = 0;
  for (const BagMessage& message : messages) {
    const std::uint32_t number = numbers.of(message);
    if (!known[number]) {
      connections += rosConnection(number, message);
      chunk += rosConnection(number, message);
    }
    known[number] = true;
    entries[number] += rosTime(message.log_ns) + le(static_cast<std::uint32_t>(chunk.size()));
    first_ns =
        in_chunk % shape.chunk_messages == 0 ? message.log_ns : std::min(first_ns, message.log_ns);
    last_ns =
        in_chunk % shape.chunk_messages == 0 ? message.log_ns : std::max(last_ns, message.log_ns);
    ++counts[number];
    chunk += rosRecord(
        field("op", "\x02") + field("conn", le(number)) + field("time", rosTime(message.log_ns)),
        message.bytes);
    if (++in_chunk % shape.chunk_messages == 0) finishChunk();
  }
  finishChunk();
  if (!shape.is_closed) return file;
  const std::string head = begin(file.size());
  return head + file.substr(head.size()) + connections + chunk_infos;
}

void writeDatabase(const std::string& path, const std::vector<BagMessage>& messages) {
  const Numbers numbers(messages);
  std::filesystem::remove(path);
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  const auto run = [&](const std::string& text, const std::string& blob = {}) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database, text.c_str(), -1, &statement, nullptr);
    sqlite3_bind_blob(statement, 1, blob.data(), static_cast<int>(blob.size()), SQLITE_STATIC);
    const int state = sqlite3_step(statement);
    sqlite3_finalize(statement);
    if (state != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(database));
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
      "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)");
  run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER "
      "NOT NULL, data BLOB NOT NULL)");
  run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  run("BEGIN");
  for (std::size_t i = 0; i < numbers.first().size(); ++i)
    run("INSERT INTO topics VALUES(" + std::to_string(i + 1) + ", '" + numbers.first()[i]->topic +
        "', '" + ros2Type(numbers.first()[i]->type) + "', 'cdr', '')");
  for (const BagMessage& message : messages)
    run("INSERT INTO messages(topic_id, timestamp, data) VALUES(" +
            std::to_string(numbers.of(message) + 1) + ", " + std::to_string(message.log_ns) +
            ", ?)",
        message.bytes);
  run("COMMIT");
  sqlite3_close(database);
}

void writeBag(const std::string& path, const std::vector<BagMessage>& messages,
              const LogShape& shape) {
  const std::string ending = std::filesystem::path(path).extension();
  if (ending == ".db3") return writeDatabase(path, messages);
  writeText(path, ending == ".bag" ? rosBagBytes(messages, shape) : mcapBytes(messages, shape));
}

}  // namespace xview::test
