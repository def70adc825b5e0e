// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "xview/base/localization.h"

namespace xview {

/// The whole text as a number, whatever the locale; a plus may stand before it, and "nan" and "inf"
/// are numbers, too. `problem`, if given, receives why there is none.
template <class Number>
std::optional<Number> numberFrom(std::string_view text, std::errc* problem = nullptr) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const char* end = text.data() + text.size();
  auto [stop, found] = std::from_chars(text.data(), end, value);
  if (found == std::errc() && stop != end) found = std::errc::invalid_argument;
  if (problem) *problem = found;
  return found == std::errc() ? std::optional<Number>(value) : std::nullopt;
}

/// The enumerator of 0 to `last` whose toString() is this name.
template <class Enum>
std::optional<Enum> enumeratorNamed(std::string_view name, Enum last) {
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (name == toString(static_cast<Enum>(i))) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

/// The word with the smallest edit distance, for "did you mean"; the first one if several are
/// equally near, empty if none differs in about a quarter of its letters or less: what is farther
/// was hardly meant.
std::string nearestWord(const std::string& word, const std::vector<std::string>& words);

/// The end of a message about an unknown word: "; the nearest known one is X", else the known ones
/// if they are few, else nothing.
std::string knownWordsHint(const std::string& word, const std::vector<std::string>& words);

/// The fewest digits that read back as the same number.
std::string numberText(double value);

// Text that others wrote, such as names of classes and files, where it goes. What is not UTF-8 is
// taken byte by byte.

/// Without characters that steer a terminal or turn the direction of writing: "\x1b", "\u202e"
/// stand for them. Line breaks become blanks, so that a message is one line.
std::string printable(const std::string& text);
/// In double quotes; YAML reads back the same text, but for bytes that are not UTF-8.
std::string yamlQuoted(const std::string& text);
/// In double quotes as CSV has it. A spreadsheet would take what begins like a formula for one; an
/// apostrophe stands before it.
std::string csvQuoted(const std::string& text);

/// Priors as users write them. `name` is what they wrote it behind, a flag or a key: a UsageError
/// names it.
PlacePrior::Circle parseCircle(const std::string& name, const std::string& text);  ///< x,y,radius
PlacePrior::Heading parseHeading(const std::string& name,
                                 const std::string& text);  ///< heading,tolerance [deg]

/// `LOW,HIGH`, or `free` for 0.75,1.34; nothing if the text is empty: the scale is right.
std::optional<ScaleRange> parseScale(const std::string& name, const std::string& text);

/// The same as rules of options: they throw what the parsers throw.
void requireCircle(const std::string& name, const std::string& text);
void requireHeading(const std::string& name, const std::string& text);
void requireScale(const std::string& name, const std::string& text);

}  // namespace xview
