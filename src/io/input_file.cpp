// SPDX-License-Identifier: BSD-3-Clause
#include "input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "xview/types/error.h"

namespace xview::io {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

InputFile::InputFile(std::string path) : path_(std::move(path)) {
  // Not blocking: opening a pipe without a writer would wait for ever.
  descriptor_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) fail(std::string("cannot open: ") + std::strerror(errno));
  struct stat status = {};
  if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(descriptor_);
    fail(S_ISDIR(status.st_mode) ? "is a folder, expected a file" : "is not a regular file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, size_ + 1)));
}

InputFile::~InputFile() { close(descriptor_); }

bool InputFile::fillBuffer() {
  ssize_t count;
  do {
    count = ::read(descriptor_, buffer_.data(), buffer_.size());
  } while (count < 0 && errno == EINTR);
  if (count < 0) fail(std::string("cannot read: ") + std::strerror(errno));
  begin_ = 0;
  end_ = static_cast<std::size_t>(count);
  return count > 0;
}

std::string_view InputFile::takeToNewline(bool& ended) {
  const char* first = buffer_.data() + begin_;
  const auto* newline = static_cast<const char*>(std::memchr(first, '\n', end_ - begin_));
  ended = newline != nullptr;
  const std::size_t length = ended ? static_cast<std::size_t>(newline - first) : end_ - begin_;
  const std::size_t consumed = length + (ended ? 1 : 0);
  begin_ += consumed;
  position_ += consumed;
  return {first, length};
}

bool InputFile::readLine(std::string_view& line) {
  if (begin_ == end_ && !fillBuffer()) return false;
  ++line_number_;
  bool ended = false;
  line = takeToNewline(ended);
  if (!ended) {
    long_line_ = line;
    while (!ended && fillBuffer()) {
      long_line_ += takeToNewline(ended);
      if (long_line_.size() > kLongestLine) failAtLine("the line is longer than 1 MiB");
    }
    line = long_line_;
  }
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool InputFile::readWords(std::vector<std::string_view>& words, const char* comment_signs,
                          std::string_view* line) {
  std::string_view next;
  while (readLine(next)) {
    words = splitWords(next.substr(0, next.find_first_of(comment_signs)));
    if (words.empty()) continue;
    if (line) *line = next;
    return true;
  }
  return false;
}

std::vector<double> InputFile::numbersOf(const std::vector<std::string_view>& words) const {
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    const std::optional<double> number = numberFrom<double>(word);
    if (!number || !std::isfinite(*number)) {
      failAtLine("expected a finite number, found {}", quoted(word));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

void InputFile::readBytes(void* data, std::size_t bytes) {
  auto* out = static_cast<char*>(data);
  while (bytes > 0) {
    if (begin_ == end_ && !fillBuffer()) {
      fail("ends at byte {}, expected {} bytes more", position_, bytes);
    }
    const std::size_t part = std::min(bytes, end_ - begin_);
    std::memcpy(out, buffer_.data() + begin_, part);
    out += part;
    begin_ += part;
    position_ += part;
    bytes -= part;
  }
}

void InputFile::fail(const std::string& what) const { throw Error(path_, what); }

void InputFile::failAtLine(const std::string& what) const { failAtLine(line_number_, what); }

void InputFile::failAtLine(std::uint64_t line, const std::string& what) const {
  throw Error(path_ + ":" + std::to_string(line), what);
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...'" : "'");
}

std::vector<std::string_view> splitWords(std::string_view line) {
  constexpr const char* kBlanks = " \t";
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

}  // namespace xview::io
