// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace xview::map {

/// The bytes of a map file contradict themselves. Becomes an Error with the path at the border of
/// the folder.
class Damage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Bytes = std::vector<std::uint8_t>;

/// Appends integers in as few bytes as they need: seven bits per byte, least significant first.
/// Signed ones are zig-zag coded, so that small negative numbers are short too.
class ByteWriter {
 public:
  void unsignedInteger(std::uint64_t value);
  void signedInteger(std::int64_t value);
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
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

/// zlib stream behind its raw size (4 bytes, little endian). The stream carries its own checksum.
Bytes compressed(const Bytes& raw);
/// Throws Damage if the stream is broken, or claims a size that it cannot have.
Bytes decompressed(const Bytes& packed);

/// Resolution of stored single-precision coordinates: one centimetre.
constexpr double kStoredSteps = 100;  // per metre

/// Nothing farther from its origin than this fits into a map [m].
constexpr double kFarthest_m = 1e8;

/// Coordinate in whole centimetres. Throws std::out_of_range; `what` names the owner.
std::int64_t toSteps(double metres, const char* what);

inline float toMetres(std::int64_t steps) {
  return static_cast<float>(static_cast<double>(steps) / kStoredSteps);
}

inline std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

}  // namespace xview::map
