// SPDX-License-Identifier: BSD-3-Clause
// TIFF 6.0 sections 2 and 8, BigTIFF, OpenEXR file layout, ISO 10918-1 annex B.
#include "image_headers.h"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace xview::io {
namespace {

/// Whole numbers at any place of a file; 0 beyond its end.
class Numbers {
 public:
  Numbers(const std::vector<unsigned char>& bytes, bool little_endian)
      : bytes_(bytes), little_endian_(little_endian) {}

  std::uint64_t at(std::uint64_t place, std::size_t size) const {
    if (place > bytes_.size() || bytes_.size() - place < size) return 0;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8 | bytes_[place + (little_endian_ ? size - 1 - i : i)];
    return value;
  }
  bool has(std::uint64_t place) const { return place < bytes_.size(); }

 private:
  const std::vector<unsigned char>& bytes_;
  bool little_endian_;
};

// ---- TIFF

/// The value of an entry of a directory, whose type says how many bytes it has.
std::uint64_t tiffValue(const Numbers& file, std::uint64_t place, std::uint64_t type) {
  constexpr std::uint64_t kByte = 1, kShort = 3, kLong = 4, kLong8 = 16;
  if (type == kByte) return file.at(place, 1);
  if (type == kShort) return file.at(place, 2);
  if (type == kLong) return file.at(place, 4);
  return type == kLong8 ? file.at(place, 8) : 0;
}

ImageHeader tiffHeader(const Numbers& file, bool big) {
  constexpr std::uint64_t kWidth = 256, kHeight = 257, kRowsOfStrip = 278, kTileWidth = 322,
                          kTileHeight = 323;
  constexpr std::uint64_t kAllRows = 0xFFFFFFFF;
  const std::uint64_t offset = big ? 8 : 4;  // bytes of one
  const std::uint64_t directory = file.at(big ? 8 : 4, offset);
  const std::uint64_t count_bytes = big ? 8 : 2, entry_bytes = big ? 20 : 12;
  const std::uint64_t entries = file.at(directory, count_bytes);
  ImageHeader header;
  header.format = ImageFormat::tiff;
  std::uint64_t rows_of_strip = 0, tile_width = 0, tile_height = 0;
  for (std::uint64_t i = 0; i < entries; ++i) {
    const std::uint64_t entry = directory + count_bytes + i * entry_bytes;
    if (!file.has(entry) || entry < directory) break;
    const std::uint64_t tag = file.at(entry, 2);
    const std::uint64_t value = tiffValue(file, entry + (big ? 12 : 8), file.at(entry + 2, 2));
    const auto keep = [&](std::uint64_t& largest) { largest = std::max(largest, value); };
    if (tag == kWidth) keep(header.width);  // of several nobody knows which is taken
    if (tag == kHeight) keep(header.height);
    if (tag == kRowsOfStrip && value != kAllRows) keep(rows_of_strip);
    if (tag == kTileWidth) keep(tile_width);
    if (tag == kTileHeight) keep(tile_height);
  }
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
  header.strip_pixels = std::min(header.width, kMost) * std::min(rows_of_strip, kMost);
  header.tile_pixels = std::min(tile_width, kMost) * std::min(tile_height, kMost);
  return header;
}

// ---- EXR

/// The text at a place, up to its zero; its end is the zero.
std::string_view exrText(const std::vector<unsigned char>& bytes, std::size_t& place) {
  const std::size_t begin = std::min(place, bytes.size());
  place = begin;
  while (place < bytes.size() && bytes[place] != 0) ++place;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + begin, place - begin);
  ++place;
  return text;
}

/// Attributes are name, type, size of the value, value; an empty name ends them. OpenEXR makes room
/// for a value of any size before it reads it.
ImageHeader exrHeader(const std::vector<unsigned char>& bytes) {
  const Numbers file(bytes, true);
  ImageHeader header;
  header.format = ImageFormat::exr;
  constexpr std::uint64_t kDeepOrOfParts = 0x1800;
  if (file.at(4, 4) & kDeepOrOfParts) header.damage = "an EXR of several parts or deep pixels";
  for (std::size_t place = 8; place < bytes.size();) {
    const std::string_view name = exrText(bytes, place);
    if (name.empty()) break;
    exrText(bytes, place);  // its type
    const std::uint64_t size = file.at(place, 4);
    place += 4;
    const auto number = [&](std::size_t i) {
      return static_cast<std::int64_t>(static_cast<std::int32_t>(file.at(place + 4 * i, 4)));
    };
    if (name == "dataWindow") {
      header.width =
          static_cast<std::uint64_t>(std::max<std::int64_t>(0, number(2) - number(0) + 1));
      header.height =
          static_cast<std::uint64_t>(std::max<std::int64_t>(0, number(3) - number(1) + 1));
    }
    if (name == "tiles") header.tile_pixels = file.at(place, 4) * file.at(place + 4, 4);
    const std::uint64_t left = bytes.size() - std::min(place, bytes.size());
    if (size > left) {
      header.damage = "an EXR attribute of " + std::to_string(size) + " bytes, where " +
                      std::to_string(left) + " are left";
      break;
    }
    place += size;
  }
  return header;
}

// ---- JPEG

/// Segments are FF, marker, length of the rest, rest; the size stands in the one that begins the
/// frame.
ImageHeader jpegHeader(const std::vector<unsigned char>& bytes) {
  const Numbers file(bytes, false);
  ImageHeader header;
  header.format = ImageFormat::jpeg;
  for (std::size_t place = 2; place + 4 <= bytes.size();) {
    if (bytes[place] != 0xFF) break;
    const unsigned char marker = bytes[place + 1];
    if (marker == 0xFF) {  // filling
      ++place;
      continue;
    }
    const bool begins_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (begins_frame) {
      header.height = std::max(header.height, file.at(place + 5, 2));
      header.width = std::max(header.width, file.at(place + 7, 2));
    }
    if (marker == 0xDA) break;  // pixels
    place += 2 + std::max<std::uint64_t>(2, file.at(place + 2, 2));
  }
  return header;
}

bool beginsWith(const std::vector<unsigned char>& bytes, std::string_view text) {
  return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

}  // namespace

ImageHeader imageHeader(const std::vector<unsigned char>& bytes) {
  using std::string_view_literals::operator""sv;
  if (beginsWith(bytes, "\x89PNG"sv)) return {ImageFormat::png};
  for (const bool little : {true, false}) {
    const Numbers file(bytes, little);
    if (!beginsWith(bytes, little ? "II"sv : "MM"sv)) continue;
    const std::uint64_t version = file.at(2, 2);
    if (version == 42 || version == 43) return tiffHeader(file, version == 43);
  }
  if (beginsWith(bytes, "\x76\x2F\x31\x01"sv)) return exrHeader(bytes);
  if (beginsWith(bytes, "\xFF\xD8\xFF"sv)) return jpegHeader(bytes);
  return {};
}

bool endsAsJpeg(const std::vector<unsigned char>& bytes) {
  const unsigned char start[] = {0xFF, 0xDA}, end[] = {0xFF, 0xD9};
  const auto pixels = std::find_end(bytes.begin(), bytes.end(), start, start + 2);
  return std::search(pixels, bytes.end(), end, end + 2) != bytes.end();
}

}  // namespace xview::io
