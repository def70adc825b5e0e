// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/user_text.h"

namespace xview::io {

/// A regular file that is read by lines and by bytes, mostly once from front to back. Its size is
/// known before anything is read, so that headers can be checked against it. All functions throw
/// Error.
class InputFile {
 public:
  explicit InputFile(std::string path);

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t remaining() const { return size_ > position_ ? size_ - position_ : 0; }

  /// The next line without its end ("\n" or "\r\n"); false at the end of the file. The view lives
  /// until the next call.
  bool readLine(std::string_view& line);
  /// The words of the next line that has any, without what follows one of the characters that begin
  /// a comment; false at the end of the file. `line`, if given, receives the whole line.
  bool readWords(std::vector<std::string_view>& words, const char* comment_signs = "",
                 std::string_view* line = nullptr);
  std::uint64_t lineNumber() const { return line_number_; }  ///< of the line read last, from 1

  void readBytes(void* data, std::size_t bytes);  ///< exactly this number
  /// The next byte is the one at this position, which may be anywhere in the file.
  void seek(std::uint64_t position);

  /// Throws Error unless the word of the line read last is short enough to name a file.
  void requireFileName(std::string_view word) const;
  /// Words of the line read last as finite numbers.
  std::vector<double> numbersOf(const std::vector<std::string_view>& words) const;

  [[noreturn]] void fail(const std::string& what) const;        ///< "path: what"
  [[noreturn]] void failAtLine(const std::string& what) const;  ///< "path:line: what", read last
  [[noreturn]] void failAtLine(std::uint64_t line, const std::string& what) const;
  /// The same with a text of fmt and what belongs into its braces.
  template <class Value, class... Values>
  [[noreturn]] void fail(fmt::format_string<Value, Values...> text, Value&& value,
                         Values&&... values) const {
    fail(fmt::format(text, std::forward<Value>(value), std::forward<Values>(values)...));
  }
  template <class Value, class... Values>
  [[noreturn]] void failAtLine(fmt::format_string<Value, Values...> text, Value&& value,
                               Values&&... values) const {
    failAtLine(fmt::format(text, std::forward<Value>(value), std::forward<Values>(values)...));
  }

 private:
  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
  std::uint64_t line_number_ = 0;
  std::string line_;  ///< the one read last
};

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary files are read by copying bytes");

/// A number as it stands in a file.
template <class T>
T storedNumber(const char* bytes, bool big_endian) {
  char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (big_endian) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return value;
}

/// And as it is written, little-endian.
template <class T>
void appendNumber(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// A piece of a file for a message: printable, one line, not longer than 40 characters, in quotes.
std::string inQuotes(std::string_view text);

/// FILE.e57#2 is the second setup of an E57; every other path is that of a file.
struct SetupPath {
  std::string file;
  std::size_t setup = 0;  ///< counted from 1; 0 = all
};
SetupPath setupPathOf(const std::string& path);

/// What the path of a file ends in, in lower case: ".pcd".
std::string endingOf(const std::string& path);

/// The lines of a text, without their ends.
std::vector<std::string> linesOf(const std::string& text);

/// The words of a line, separated by blanks and tabs.
std::vector<std::string_view> splitWords(std::string_view line);

}  // namespace xview::io
