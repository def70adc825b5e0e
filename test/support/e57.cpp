// SPDX-License-Identifier: BSD-3-Clause
#include "support/e57.h"

#include <algorithm>
#include <cstring>

namespace xview::test {
namespace {

constexpr std::size_t kContent = 1020;

template <class T>
std::string bytesOf(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  bytes.replace(at, sizeof(T), bytesOf(value));
}

std::uint64_t physical(std::size_t at) { return at / kContent * 1024 + at % kContent; }

std::uint64_t storedBits(const E57Column& column, double value) {
  std::uint64_t bits = 0;
  const auto single = static_cast<float>(value);
  if (!column.is_real)
    bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(value) - column.minimum);
  else if (column.bits == 32)
    std::memcpy(&bits, &single, sizeof(single));
  else
    std::memcpy(&bits, &value, sizeof(value));
  return bits;
}

/// The values of a column, lowest bit first.
std::string streamOf(const E57Points& points, std::size_t column) {
  std::vector<bool> bits;
  for (const std::vector<double>& row : points.rows) {
    const std::uint64_t value = storedBits(points.columns[column], row[column]);
    for (int i = 0; i < points.columns[column].bits; ++i) bits.push_back(value >> i & 1);
  }
  std::string bytes((bits.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i]) bytes[i / 8] = static_cast<char>(bytes[i / 8] | 1 << i % 8);
  return bytes;
}

/// `packet` of a scan: its share of every stream, wherever that cuts a value.
std::string packetOf(const E57Points& points, std::size_t packet) {
  std::string sizes, streams;
  for (std::size_t column = 0; column < points.columns.size(); ++column) {
    const std::string all = streamOf(points, column);
    const std::size_t share = (all.size() + points.packets - 1) / points.packets;
    const std::string part = all.substr(std::min(all.size(), packet * share), share);
    sizes += bytesOf(static_cast<std::uint16_t>(part.size()));
    streams += part;
  }
  std::string body = bytesOf(static_cast<std::uint16_t>(points.columns.size())) + sizes + streams;
  body.resize((body.size() + 3) / 4 * 4, '\0');
  return std::string("\1\0", 2) + bytesOf(static_cast<std::uint16_t>(body.size() + 3)) + body;
}

void appendSection(const E57Points& points, std::string& content) {
  const std::size_t begin = content.size();
  content += std::string("\1\0\0\0\0\0\0\0", 8) + std::string(24, '\0');
  const std::string other = std::string("\0\0\x0F\0", 4) + std::string(12, '\0');
  for (std::size_t i = 0; i < points.packets; ++i)
    content += (points.has_index ? other : "") + packetOf(points, i);
  put(content, begin + 8, std::uint64_t{content.size() - begin});
  put(content, begin + 16, physical(begin + 32));
}

std::string xmlOf(const E57Points& points, std::size_t section) {
  std::string prototype;
  for (const E57Column& column : points.columns)
    prototype += "<" + column.name + " " + column.attributes + "/>\n";
  return "<vectorChild type=\"Structure\">\n" + points.pose +
         "<points type=\"CompressedVector\" fileOffset=\"" + std::to_string(physical(section)) +
         "\" recordCount=\"" + std::to_string(points.rows.size()) +
         "\">\n<prototype type=\"Structure\">\n" + prototype +
         "</prototype>\n</points>\n</vectorChild>\n";
}

std::uint32_t sumOf(const std::string& bytes) {
  std::uint32_t sum = 0xFFFFFFFF;
  for (const char byte : bytes) {
    for (int bit = 0; bit < 8; ++bit) {
      const bool odd = ((sum ^ static_cast<std::uint8_t>(byte) >> bit) & 1) != 0;
      sum = sum >> 1 ^ (odd ? 0x82F63B78 : 0);
    }
  }
  return ~sum;
}

}  // namespace

E57Column e57Real(const std::string& name, int bits) {
  return {name, std::string("type=\"Float\"") + (bits == 32 ? " precision=\"single\"" : ""), bits,
          true, 0};
}

E57Column e57Whole(const std::string& name, std::int64_t minimum, std::int64_t maximum,
                   const std::string& scale) {
  int bits = 0;
  while (maximum - minimum >= std::int64_t{1} << bits) ++bits;
  return {name,
          std::string("type=\"") + (scale.empty() ? "Integer" : "ScaledInteger") + "\" minimum=\"" +
              std::to_string(minimum) + "\" maximum=\"" + std::to_string(maximum) + "\" " + scale,
          bits, false, minimum};
}

std::string e57Content(const std::vector<E57Points>& scans, const std::string& from,
                       const std::string& to) {
  std::string content = "ASTM-E57" + bytesOf(std::uint32_t{1}) + std::string(36, '\0');
  put(content, 40, std::uint64_t{1024});
  std::string data;
  for (const E57Points& scan : scans) {
    const std::size_t section = content.size();
    appendSection(scan, content);
    data += xmlOf(scan, section);
  }
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
      "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n<coordinateMetadata "
      "type=\"String\"><![CDATA[EPSG:25832]]></coordinateMetadata>\n<data3D type=\"Vector\">\n" +
      data + "</data3D>\n</e57Root>\n";
  if (const std::size_t at = xml.find(from); !from.empty() && at != std::string::npos)
    xml.replace(at, from.size(), to);
  put(content, 24, physical(content.size()));
  put(content, 32, std::uint64_t{xml.size()});
  return content + xml;
}

std::string e57Paged(std::string content) {
  const std::size_t pages = (content.size() + kContent - 1) / kContent;
  content.resize(pages * kContent, '\0');
  if (pages > 0) put(content, 16, std::uint64_t{pages * 1024});
  std::string file;
  for (std::size_t i = 0; i < pages; ++i) {
    const std::string page = content.substr(i * kContent, kContent);
    std::string sum = bytesOf(sumOf(page));
    std::reverse(sum.begin(), sum.end());  // the one number that is big-endian
    file += page + sum;
  }
  return file;
}

}  // namespace xview::test
