// SPDX-License-Identifier: BSD-3-Clause
#include "small_files.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "xview/base/error.h"

namespace xview::test {
namespace {

std::string bigEndian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xFF);
  return bytes;
}

/// Bit by bit, as the PNG specification defines it.
std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
  }
  return ~crc;
}

std::string chunk(const std::string& type, const std::string& data) {
  return bigEndian(static_cast<std::uint32_t>(data.size())) + type + data +
         bigEndian(crc32(type + data));
}

/// A zlib stream of stored blocks.
std::string stored(const std::string& data) {
  std::string bytes = "\x78\x01";
  std::size_t at = 0;
  do {
    const std::size_t size = std::min<std::size_t>(65535, data.size() - at);
    bytes += at + size == data.size() ? '\1' : '\0';
    for (const std::size_t number : {size, ~size}) {
      bytes += static_cast<char>(number & 0xFF);
      bytes += static_cast<char>(number >> 8 & 0xFF);
    }
    bytes += data.substr(at, size);
    at += size;
  } while (at < data.size());
  std::uint32_t a = 1, b = 0;
  for (const char c : data) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  return bytes + bigEndian(b << 16 | a);
}

template <class T>
std::string rawBytes(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace

std::string pngBytes(int width, int height, int channels, int bits,
                     const std::vector<std::uint16_t>& values) {
  static constexpr int kColorType[] = {0, 0, 4, 2, 6};
  std::string rows;
  std::size_t next = 0;
  for (int y = 0; y < height; ++y) {
    rows += '\0';  // no filter
    for (int i = 0; i < width * channels; ++i, ++next) {
      if (bits == 16) rows += static_cast<char>(values.at(next) >> 8);
      rows += static_cast<char>(values.at(next) & 0xFF);
    }
  }
  return pngBytes(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                  kColorType[channels], bits, rows);
}

std::string pngBytes(std::uint32_t width, std::uint32_t height, int color_type, int bits,
                     const std::string& rows, bool interlaced) {
  std::string header = bigEndian(width) + bigEndian(height);
  header += static_cast<char>(bits);
  header += static_cast<char>(color_type);
  header += std::string(2, '\0') + (interlaced ? '\1' : '\0');
  const std::string palette =
      color_type == 3 ? chunk("PLTE", std::string("\xFF\0\0\0\xFF\0", 6)) : "";
  return "\x89PNG\r\n\x1A\n" + chunk("IHDR", header) + palette + chunk("IDAT", stored(rows)) +
         chunk("IEND", "");
}

std::string pfmBytes(int width, int height, const std::vector<float>& values, bool little_endian) {
  std::string bytes = "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n" +
                      (little_endian ? "-1.0\n" : "1.0\n");
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) {
      char raw[4];
      std::memcpy(raw, &values.at(static_cast<std::size_t>(y * width + x)), 4);
      if (!little_endian) std::reverse(raw, raw + 4);
      bytes.append(raw, 4);
    }
  }
  return bytes;
}

std::string scanBytes(const std::vector<float>& numbers) { return rawBytes(numbers); }
std::string labelBytes(const std::vector<std::uint32_t>& labels) { return rawBytes(labels); }

}  // namespace xview::test
