// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace xview {

/// The word with the smallest edit distance, for "did you mean"; the first one if several are
/// equally near, empty if there are no words.
std::string nearestWord(const std::string& word, const std::vector<std::string>& words);

}  // namespace xview
