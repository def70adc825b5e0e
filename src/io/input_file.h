// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace xview {

/// A regular file that is read once from front to back, by lines and by bytes, through one small
/// buffer. Its size is known before anything is read, so that headers can be checked against it.
/// All functions throw Error.
class InputFile {
 public:
  explicit InputFile(std::string path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t remaining() const { return size_ > position_ ? size_ - position_ : 0; }

  /// The next line without its end ("\n" or "\r\n"); false at the end of the file. The view lives
  /// until the next call.
  bool readLine(std::string_view& line);
  std::uint64_t lineNumber() const { return line_number_; }  ///< of the line read last, from 1

  void readBytes(void* data, std::size_t bytes);  ///< exactly so many

  [[noreturn]] void fail(const std::string& what) const;  ///< "path: what"
  [[noreturn]] void failAtLine(
      const std::string& what) const;  ///< "path:line: what", the line read last
  [[noreturn]] void failAtLine(std::uint64_t line, const std::string& what) const;

 private:
  bool fillBuffer();
  std::string_view takeToNewline(bool& ended);  ///< what the buffer has of the line

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
  std::uint64_t line_number_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< bytes of the buffer that are not consumed yet
  std::string long_line_;            ///< a line that spans buffers
};

/// A piece of a file for a message: printable, one line, not longer than 40 characters, in quotes.
std::string quoted(std::string_view text);

}  // namespace xview
