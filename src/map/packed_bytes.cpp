// SPDX-License-Identifier: BSD-3-Clause
#include "packed_bytes.h"

#include <zlib.h>

#include <new>

namespace xview::map {
namespace {

constexpr std::size_t kSizeBytes = 4;
constexpr std::size_t kBestRatio = 1032;  // of deflate: 258 bytes from two bits

}  // namespace

void ByteWriter::unsignedInteger(std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::uint8_t>(value | 0x80));
  bytes_.push_back(static_cast<std::uint8_t>(value));
}

void ByteWriter::signedInteger(std::int64_t value) {
  unsignedInteger((static_cast<std::uint64_t>(value) << 1) ^ (value < 0 ? ~std::uint64_t{0} : 0));
}

std::uint64_t ByteReader::unsignedInteger() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (next_ == end_) throw Damage("packed numbers end too early");
    const std::uint8_t byte = *next_++;
    value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
    if (byte < 0x80) return value;
  }
  throw Damage("packed number longer than 64 bits");
}

std::int64_t ByteReader::signedInteger() {
  const std::uint64_t coded = unsignedInteger();
  return static_cast<std::int64_t>((coded >> 1) ^ (~(coded & 1) + 1));
}

Bytes compressed(const Bytes& raw) {
  if (raw.size() > 0xFFFFFFFFu) throw std::length_error("a tile of more than 4 GB");
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  Bytes packed(kSizeBytes + size);
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    packed[i] = static_cast<std::uint8_t>(raw.size() >> (8 * i));
  const int result =
      compress2(packed.data() + kSizeBytes, &size, raw.data(), static_cast<uLong>(raw.size()), 6);
  if (result != Z_OK) throw std::bad_alloc();
  packed.resize(kSizeBytes + size);
  return packed;
}

Bytes decompressed(const Bytes& packed) {
  if (packed.size() < kSizeBytes) throw Damage("packed block too short");
  std::size_t raw_size = 0;
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    raw_size |= static_cast<std::size_t>(packed[i]) << (8 * i);
  if (raw_size > packed.size() * kBestRatio)
    throw Damage("packed block announces an impossible size");
  Bytes raw(raw_size + 1);  // one spare byte tells a stream that is longer than announced
  uLongf size = static_cast<uLongf>(raw.size());
  const int result = uncompress(raw.data(), &size, packed.data() + kSizeBytes,
                                static_cast<uLong>(packed.size() - kSizeBytes));
  if (result != Z_OK || size != raw_size) throw Damage("packed block does not decompress");
  raw.resize(raw_size);
  return raw;
}

std::int64_t toSteps(double metres, const char* what) {
  if (!(std::abs(metres) <= kFarthest_m)) {
    throw std::out_of_range(std::string(what) + " at " + std::to_string(metres) +
                            " m from the origin; at most 100000 km fit into a map");
  }
  return std::llround(metres * kStoredSteps);
}

}  // namespace xview::map
