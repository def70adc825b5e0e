// SPDX-License-Identifier: BSD-3-Clause
#include "base/user_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "xview/base/error.h"

namespace xview {
namespace {

/// Levenshtein distance, one row at a time.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

double parseNumber(const std::string& text) {
  std::size_t used = 0;
  const double number = std::stod(text, &used);
  if (used != text.size() || !std::isfinite(number)) throw std::invalid_argument(text);
  return number;
}

std::vector<double> parseNumbers(const std::string& name, const std::string& text,
                                 std::size_t count, const char* meaning) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    try {
      numbers.push_back(parseNumber(part));
    } catch (const std::logic_error&) {  // what std::stod throws, too
      throw UsageError(name + " = " + text + ", '" + part + "' is not a number");
    }
  }
  if (numbers.size() != count) throw UsageError(name + " = " + text + ", must be " + meaning);
  return numbers;
}

// ---- characters

/// A character of a text: its code point, nothing if its bytes are not UTF-8 (which are then taken
/// one by one), and the bytes.
struct Character {
  std::optional<std::uint32_t> code;
  std::string bytes;
};

Character characterAt(const std::string& text, std::size_t place) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(place);
  const std::size_t size = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : 4;
  constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  if (size == 1) return {first, text.substr(place, 1)};
  std::uint32_t code = first & (0x7Fu >> size);
  bool is_utf8 = first >> 3 <= 30 && first >= 0xC2 && place + size <= text.size();
  for (std::size_t i = 1; is_utf8 && i < size; ++i) {
    is_utf8 = byte(place + i) >> 6 == 2;
    code = code << 6 | (byte(place + i) & 0x3Fu);
  }
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (!is_utf8 || code < kSmallest[size] || code > 0x10FFFF || is_surrogate)
    return {std::nullopt, text.substr(place, 1)};
  return {code, text.substr(place, size)};
}

/// Of terminals (C0, C1), of the direction of writing, and line breaks of Unicode.
bool isControl(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x61C || code == 0xFEFF ||
         (code >= 0x200E && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) ||
         (code >= 0x2066 && code <= 0x2069);
}

/// "\x1b", "\u202e": as YAML and many languages write it.
std::string escaped(std::uint32_t code) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text = code < 0x100 ? "\\x" : "\\u";
  for (int shift = code < 0x100 ? 4 : 12; shift >= 0; shift -= 4)
    text += kDigits[code >> shift & 0xF];
  return text;
}

/// write(character) for each.
template <class Write>
std::string rewritten(const std::string& text, Write&& write) {
  std::string result;
  for (std::size_t place = 0; place < text.size();) {
    const Character character = characterAt(text, place);
    result += write(character);
    place += character.bytes.size();
  }
  return result;
}

std::string withoutControl(const Character& c) {
  if (c.code && !isControl(*c.code)) return c.bytes;
  return escaped(c.code.value_or(static_cast<unsigned char>(c.bytes[0])));
}

}  // namespace

std::string printable(const std::string& text) {
  return rewritten(text, [](const Character& c) {
    const bool breaks_line = c.bytes == "\n" || c.bytes == "\r";
    return breaks_line ? std::string(" ") : withoutControl(c);
  });
}

std::string yamlQuoted(const std::string& text) {
  return "\"" +
         rewritten(text,
                   [](const Character& c) {
                     const bool is_special = c.bytes == "\"" || c.bytes == "\\";
                     return is_special ? "\\" + c.bytes : withoutControl(c);
                   }) +
         "\"";
}

std::string csvQuoted(const std::string& text) {
  const bool is_formula =
      !text.empty() && std::string("=+-@\t\r\n").find(text[0]) != std::string::npos;
  std::string out = is_formula ? "\"'" : "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string numberText(double value) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& words) {
  std::string nearest;
  std::size_t smallest = std::max<std::size_t>((word.size() + 2) / 4, 1) + 1;  // too far
  for (const std::string& candidate : words) {
    const std::size_t longer = std::max(word.size(), candidate.size());
    if (longer - std::min(word.size(), candidate.size()) >= smallest) continue;
    const std::size_t distance = editDistance(word, candidate);
    if (distance < smallest) {
      smallest = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string knownWordsHint(const std::string& word, const std::vector<std::string>& words) {
  constexpr std::size_t kFew = 20;
  const std::string nearest = nearestWord(word, words);
  if (!nearest.empty()) return "; the nearest known one is " + nearest;
  if (words.empty() || words.size() > kFew) return "";
  std::string list;
  for (const std::string& known : words) list += (list.empty() ? "; known are " : ", ") + known;
  return list;
}

PlacePrior::Circle parseCircle(const std::string& name, const std::string& text) {
  const auto n = parseNumbers(name, text, 3, "x,y,radius");
  if (!(n[2] > 0)) throw UsageError(name + " = " + text + ", the radius must be positive");
  return {n[0], n[1], n[2]};
}

PlacePrior::Heading parseHeading(const std::string& name, const std::string& text) {
  const auto n = parseNumbers(name, text, 2, "heading,tolerance");
  if (!(n[1] > 0)) throw UsageError(name + " = " + text + ", the tolerance must be positive");
  return {n[0] * M_PI / 180, n[1] * M_PI / 180};
}

std::optional<ScaleRange> parseScale(const std::string& name, const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == "free") return ScaleRange{0.75, 1.34};
  const auto n = parseNumbers(name, text, 2, "LOW,HIGH or free");
  if (!(n[0] > 0.1 && n[0] <= n[1] && n[1] < 10))
    throw UsageError(name + " = " + text + ", must be 0.1 < LOW <= HIGH < 10");
  return ScaleRange{n[0], n[1]};
}

void requireCircle(const std::string& name, const std::string& text) { parseCircle(name, text); }

void requireHeading(const std::string& name, const std::string& text) { parseHeading(name, text); }

void requireScale(const std::string& name, const std::string& text) { parseScale(name, text); }

}  // namespace xview
