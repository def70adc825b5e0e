// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "io/input_file.h"

namespace xview::io {

/// How the values of a message follow one another. ROS 1, and the records of logs: without gaps,
/// little-endian. CDR (OMG DDS-RTPS, XCDR1), of ROS 2: each at a multiple of its size from the byte
/// behind an encapsulation header, which says the byte order.
enum class Serialization { ros1, cdr };

/// Reads values one behind the other and never beyond the last byte. What does not fit is an Error
/// of the file.
class Cursor {
 public:
  Cursor(const InputFile& file, std::string_view bytes, Serialization serialization)
      : file_(file), bytes_(bytes), serialization_(serialization) {
    if (serialization == Serialization::ros1) return;
    const std::string_view header = take(4);
    big_endian_ = header[1] == 0;
    if (header[0] != 0 || (header[1] != 0 && header[1] != 1))
      fail("expected plain CDR (encapsulation 0 or 1), found {}",
           static_cast<unsigned char>(header[0]) * 256 + static_cast<unsigned char>(header[1]));
    origin_ = position_;
  }

  template <class T>
  T number() {
    align(sizeof(T));
    return storedNumber<T>(take(sizeof(T)).data(), big_endian_);
  }
  std::string_view take(std::uint64_t bytes) {
    if (bytes > remaining())
      fail("expected {} bytes more at its byte {}, found {}", bytes, position_, remaining());
    const std::string_view taken = bytes_.substr(position_, bytes);
    position_ += static_cast<std::size_t>(bytes);
    return taken;
  }
  /// In CDR the length counts the zero at the end.
  std::string_view text() {
    const std::string_view content = take(number<std::uint32_t>());
    return content.substr(0, content.find('\0'));
  }
  /// The length of a sequence whose elements have at least this number of bytes each.
  std::uint32_t count(std::uint64_t element_bytes) {
    const auto elements = number<std::uint32_t>();
    if (elements > remaining() / element_bytes)
      fail("a sequence of {} elements, but {} bytes follow", elements, remaining());
    return elements;
  }
  void align(std::size_t bytes) {
    if (serialization_ == Serialization::ros1) return;
    while ((position_ - origin_) % bytes != 0) take(1);
  }

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }
  bool isBigEndian() const { return big_endian_; }
  bool isRos1() const { return serialization_ == Serialization::ros1; }
  const InputFile& file() const { return file_; }

  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> text, Values&&... values) const {
    file_.fail(fmt::format(text, std::forward<Values>(values)...));
  }

 private:
  const InputFile& file_;
  std::string_view bytes_;
  Serialization serialization_;
  bool big_endian_ = false;
  std::size_t position_ = 0, origin_ = 0;
};

}  // namespace xview::io
