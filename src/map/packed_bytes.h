// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview {

using Bytes = std::vector<std::uint8_t>;

/// Appends integers in as few bytes as they need: seven bits per byte, least significant first.
/// Signed ones are zig-zag coded, so that small negative numbers are short too.
class ByteWriter {
 public:
  void unsignedInteger(std::uint64_t value);
  void signedInteger(std::int64_t value);
  void raw(const std::uint8_t* data, std::size_t size) {
    bytes_.insert(bytes_.end(), data, data + size);
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

/// Reads what ByteWriter wrote; throws Damage when the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(const Bytes& bytes)
      : next_(bytes.data()), end_(bytes.data() + bytes.size()) {}
  std::uint64_t unsignedInteger();
  std::int64_t signedInteger();
  /// A number of items that follow, each at least one byte long; so memory is bounded by the bytes
  /// that are there.
  std::size_t itemCount();
  const std::uint8_t* raw(std::size_t size);
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

/// zlib stream behind its raw size (4 bytes, little endian). The stream carries its own checksum.
Bytes compressed(const Bytes& raw);
/// Throws Damage if the stream is broken, or claims a size that it cannot have.
Bytes decompressed(const Bytes& packed);

}  // namespace xview
