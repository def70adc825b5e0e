// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace xview {

/// The word with the smallest edit distance, for "did you mean"; the first one if several are
/// equally near, empty if none differs in about a quarter of its letters or less: what is farther
/// was hardly meant.
std::string nearestWord(const std::string& word, const std::vector<std::string>& words);

/// The end of a message about an unknown word: "; the nearest known one is X", else the known ones
/// if they are few, else nothing.
std::string knownWordsHint(const std::string& word, const std::vector<std::string>& words);

}  // namespace xview
