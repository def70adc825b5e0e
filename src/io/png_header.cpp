// SPDX-License-Identifier: BSD-3-Clause
#include "png_header.h"

#include <libdeflate.h>

#include <cstdint>
#include <cstring>
#include <string_view>

#include "xview/types/error.h"

namespace xview {
namespace {

constexpr unsigned char kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::uint64_t kMaxSide = 32768;
constexpr std::uint64_t kMaxInflation = 1032;  ///< deflate cannot expand a byte to more

std::uint32_t bigEndian(const unsigned char* data) {
  return std::uint32_t{data[0]} << 24 | std::uint32_t{data[1]} << 16 | std::uint32_t{data[2]} << 8 |
         data[3];
}

int channelsOf(PngColor color) {
  switch (color) {
    case PngColor::grey:
    case PngColor::palette:
      return 1;
    case PngColor::grey_alpha:
      return 2;
    case PngColor::rgb:
      return 3;
    case PngColor::rgba:
      return 4;
  }
  return 0;
}

PngHeader parseHeader(const std::string& path, const unsigned char* data, std::size_t size) {
  if (size != 13)
    throw Error(path, "PNG header of " + std::to_string(size) + " bytes, expected 13");
  const std::uint32_t width = bigEndian(data), height = bigEndian(data + 4);
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) {
    throw Error(path, "PNG of " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels, expected 1 to " + std::to_string(kMaxSide) + " each way");
  }
  PngHeader header;
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  header.bits = data[8];
  header.color = static_cast<PngColor>(data[9]);
  header.interlaced = data[12] != 0;
  if (channelsOf(header.color) == 0 || header.bits == 0 || header.bits > 16) {
    throw Error(path, "PNG with colour type " + std::to_string(data[9]) + " and " +
                          std::to_string(data[8]) + " bits per channel");
  }
  return header;
}

}  // namespace

PngHeader checkPng(const std::string& path, const std::vector<unsigned char>& bytes) {
  if (bytes.size() < 8 || std::memcmp(bytes.data(), kSignature, 8) != 0) {
    throw Error(path, "not a PNG file: wrong signature");
  }
  PngHeader header;
  std::uint64_t packed_bytes = 0;
  for (std::size_t at = 8;;) {
    const std::string place = "PNG damaged at byte " + std::to_string(at) + ": ";
    if (bytes.size() - at < 12) throw Error(path, place + "the file ends inside a chunk");
    const unsigned char* chunk = bytes.data() + at;
    const std::uint64_t length = bigEndian(chunk);
    if (length > bytes.size() - at - 12) {
      throw Error(path, place + "a chunk of " + std::to_string(length) + " bytes, only " +
                            std::to_string(bytes.size() - at - 12) + " are left");
    }
    if (libdeflate_crc32(0, chunk + 4, length + 4) != bigEndian(chunk + 8 + length)) {
      throw Error(path, place + "wrong checksum");
    }
    const std::string_view type(reinterpret_cast<const char*>(chunk) + 4, 4);
    if ((at == 8) != (type == "IHDR")) throw Error(path, place + "header missing or twice");
    if (type == "IHDR") header = parseHeader(path, chunk + 8, length);
    if (type == "tRNS") header.has_transparent_color = true;
    if (type == "IDAT") {
      packed_bytes += length;
      header.data.push_back({at + 8, static_cast<std::size_t>(length)});
    }
    if (type == "IEND") break;
    at += 12 + length;
  }
  const auto pixels = static_cast<std::uint64_t>(header.width) * header.height;
  const std::uint64_t raw_bytes = pixels * header.bits * channelsOf(header.color) / 8;
  if (raw_bytes > packed_bytes * kMaxInflation) {
    throw Error(path, "PNG with " + std::to_string(packed_bytes) + " bytes of data cannot hold " +
                          std::to_string(header.width) + " x " + std::to_string(header.height) +
                          " pixels");
  }
  return header;
}

std::string describe(const PngHeader& header) {
  static constexpr const char* kNames[] = {"grey", "", "RGB", "palette", "grey+alpha", "", "RGBA"};
  return std::to_string(header.bits) + "-bit " + kNames[static_cast<int>(header.color)];
}

}  // namespace xview
