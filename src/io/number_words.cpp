// SPDX-License-Identifier: BSD-3-Clause
#include "number_words.h"

#include <charconv>

namespace xview {
namespace {

template <class T>
std::optional<T> parseWhole(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  T value{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> asNumber(std::string_view word) { return parseWhole<double>(word); }
std::optional<std::int64_t> asInteger(std::string_view word) {
  return parseWhole<std::int64_t>(word);
}

}  // namespace xview
