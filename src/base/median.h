// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace xview {

/// The value of this rank, ascending from 0. Reorders the values.
template <class T>
T rankedOf(std::vector<T>& values, std::size_t rank) {
  const auto value = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), value, values.end());
  return *value;
}

/// The value below which this share of the values lies, of 0.5 and an even number of values the
/// upper one of the middle two. Reorders them. There must be one value at least.
template <class T>
T quantileOf(T* first, T* last, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(last - first));
  T* const value = std::min(first + at, last - 1);
  std::nth_element(first, value, last);
  return *value;
}

template <class T>
T quantileOf(std::vector<T>& values, double share) {
  return quantileOf(values.data(), values.data() + values.size(), share);
}

template <class T>
T medianOf(std::vector<T> values) {
  return quantileOf(values, 0.5);
}

/// `count` of a list or cloud, evenly spread over its order.
template <class Things>
Things evenlySpread(const Things& all, std::size_t count) {
  count = std::min<std::size_t>(all.size(), count);
  Things chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(all[k * all.size() / count]);
  return chosen;
}

}  // namespace xview
