// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/user_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "xview/types/error.h"

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

}  // namespace

std::string numberText(double value) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& words) {
  std::string nearest;
  std::size_t smallest = std::max<std::size_t>((word.size() + 2) / 4, 1) + 1;  // too far
  for (const std::string& candidate : words) {
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
