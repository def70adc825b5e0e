// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/input_file.h"

namespace xview::io {

// ASTM E57 (E2807): pages of 1024 bytes, the last four of which are the CRC-32C of the others. In
// the others lie an XML document and, in packets, the points that it describes.

/// The bytes of such a file without the sums of its pages, which are compared as they are read. All
/// functions throw Error.
class E57Pages {
 public:
  explicit E57Pages(InputFile& file);

  const InputFile& file() const { return file_; }
  const std::string& xml() const { return xml_; }
  std::uint64_t size() const { return file_.size() / kPage * kContent; }
  std::uint64_t position() const { return position_; }
  /// The next byte is the one at this position without sums.
  void seek(std::uint64_t position);
  /// Where that byte of the file is without sums.
  std::uint64_t withoutSums(std::uint64_t physical) const;
  void read(void* data, std::size_t bytes);
  template <class T>
  T number() {
    T value;
    read(&value, sizeof(T));
    return value;
  }

 private:
  static constexpr std::uint64_t kPage = 1024, kContent = 1020;
  void readPage(std::uint64_t index);

  InputFile& file_;
  std::uint64_t position_ = 0;
  std::uint64_t page_index_ = ~std::uint64_t{0};
  std::array<char, kPage> page_{};
  std::string xml_;
};

/// A field of points: floating point, or whole numbers packed into bits.
struct E57Field {
  std::string name;     ///< cartesianX, …
  bool is_real = true;  ///< of 32 or 64 bits
  int bits = 64;        ///< 0 to 64; with 0 all are the minimum
  std::int64_t minimum = 0;
  double scale = 1, offset = 0;  ///< value = offset + scale * whole number
};

/// The points of one scan.
struct E57Scan {
  std::uint64_t section = 0;  ///< position of its section, without sums
  std::uint64_t points = 0;
  std::vector<E57Field> fields;
  Eigen::Isometry3d T_file_scan = Eigen::Isometry3d::Identity();
};

struct E57Document {
  std::vector<E57Scan> scans;
  std::string coordinates;  ///< coordinate system, as text; empty = none
};
/// What the XML says; more points than the file has bytes are an error. Throws Error.
E57Document readE57Document(const E57Pages& pages);

}  // namespace xview::io
