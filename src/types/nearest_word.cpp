// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/nearest_word.h"

#include <algorithm>
#include <numeric>

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

}  // namespace

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

}  // namespace xview
