// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

namespace xview {

/// What a short list holds for a key; a new key is added at the end, so that the list keeps the
/// order in which keys came first.
template <class Key, class Value>
Value& valueOf(std::vector<std::pair<Key, Value>>& list, const Key& key) {
  for (auto& [known, value] : list) {
    if (known == key) return value;
  }
  return list.emplace_back(key, Value()).second;
}

}  // namespace xview
