// SPDX-License-Identifier: BSD-3-Clause
#include "input_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "xview/base/error.h"

namespace xview::io {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

InputFile::InputFile(std::string path) : path_(std::move(path)) {
  namespace fs = std::filesystem;
  std::error_code problem;
  const std::string file = setupPathOf(path_).file;
  const fs::file_status status = fs::status(file, problem);
  if (fs::is_directory(status)) fail("is a folder, expected a file");
  // Asked before it is opened: opening a pipe without a writer would wait for ever.
  if (fs::exists(status) && !fs::is_regular_file(status)) fail("is not a regular file");
  file_.open(file, std::ios::binary);
  if (!file_) fail(std::string("cannot open: ") + std::strerror(errno));
  size_ = fs::file_size(file, problem);
}

bool InputFile::readLine(std::string_view& line) {
  // In pieces, because most lines are short and room for the longest one takes time to make.
  constexpr std::size_t kPiece = 4096;
  std::size_t count = 0;
  for (bool is_whole = false; !is_whole;) {
    const std::size_t room = std::min(kPiece, kLongestLine - count) + 1;
    if (line_.size() < count + room) line_.resize(count + room);
    file_.getline(line_.data() + count, static_cast<std::streamsize>(room));
    const auto got = static_cast<std::size_t>(file_.gcount());
    count += got;
    if (file_.bad()) fail(std::string("cannot read: ") + std::strerror(errno));
    is_whole = !(file_.fail() && got + 1 == room);  // else the piece is full
    if (!is_whole && count >= kLongestLine) {
      ++line_number_;
      failAtLine("the line is longer than 1 MiB");
    }
    if (!is_whole) file_.clear();
  }
  if (count == 0) return false;
  ++line_number_;
  position_ += count;
  line = std::string_view(line_).substr(0, file_.eof() ? count : count - 1);
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
      failAtLine("expected a finite number, found {}", inQuotes(word));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

void InputFile::requireFileName(std::string_view word) const {
  constexpr std::size_t kLongest = 255;  // of each part of a path
  for (std::size_t begin = 0, end = 0; end < word.size(); begin = end + 1) {
    end = std::min(word.find('/', begin), word.size());
    if (end - begin > kLongest)
      failAtLine("expected the name of a file, found {} of {} characters", inQuotes(word),
                 word.size());
  }
}

void InputFile::readBytes(void* data, std::size_t bytes) {
  file_.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes));
  const auto count = static_cast<std::size_t>(file_.gcount());
  position_ += count;
  if (file_.bad()) fail(std::string("cannot read: ") + std::strerror(errno));
  if (count < bytes) fail("ends at byte {}, expected {} bytes more", position_, bytes - count);
}

void InputFile::seek(std::uint64_t position) {
  if (position > size_) fail("ends at byte {}, expected something at byte {}", size_, position);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(position));
  if (!file_) fail(std::string("cannot read: ") + std::strerror(errno));
  position_ = position;
}

void InputFile::fail(const std::string& what) const { throw Error(path_, what); }

void InputFile::failAtLine(const std::string& what) const { failAtLine(line_number_, what); }

void InputFile::failAtLine(std::uint64_t line, const std::string& what) const {
  throw Error(path_ + ":" + std::to_string(line), what);
}

std::string inQuotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...'" : "'");
}

SetupPath setupPathOf(const std::string& path) {
  const std::size_t at = path.rfind('#');
  if (at == std::string::npos) return {path};
  const auto setup = numberFrom<std::uint32_t>(path.substr(at + 1));
  const std::string file = path.substr(0, at);
  return setup && *setup > 0 && endingOf(file) == ".e57" ? SetupPath{file, *setup}
                                                         : SetupPath{path};
}

std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(setupPathOf(path).file).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
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
