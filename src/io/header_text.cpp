// SPDX-License-Identifier: BSD-3-Clause
#include "header_text.h"

#include <algorithm>
#include <charconv>

namespace xview {

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

std::string joinFrom(const std::vector<std::string_view>& words, std::size_t first) {
  std::string text;
  for (std::size_t i = first; i < words.size(); ++i) {
    if (i > first) text += ' ';
    text += words[i];
  }
  return text;
}

std::string_view readHeaderLine(InputFile& file) {
  constexpr std::uint64_t kLongestHeader = std::uint64_t{1} << 20;
  if (file.position() > kLongestHeader) file.failAtLine("the header does not end within 1 MiB");
  std::string_view line;
  if (!file.readLine(line)) {
    file.fail(file.size() == 0 ? "the file is empty" : "ends within the header");
  }
  return line;
}

std::uint64_t parseCount(std::string_view word, const char* what, const InputFile& file,
                         std::uint64_t line) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    file.failAtLine(line,
                    std::string(what) + " must be a whole number >= 0, found " + quoted(word));
  }
  return value;
}

}  // namespace xview
