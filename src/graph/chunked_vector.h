// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace xview {

/// A vector that grows by chunks and never moves what it holds: no copies, and pages are touched
/// once.
template <class T>
class ChunkedVector {
 public:
  void push_back(const T& value) {
    if (size_ >> kBits == chunks_.size()) {
      chunks_.emplace_back();
      chunks_.back().reserve(kChunk);
    }
    chunks_.back().push_back(value);
    ++size_;
  }
  T& operator[](std::size_t i) { return chunks_[i >> kBits][i & (kChunk - 1)]; }
  const T& operator[](std::size_t i) const { return chunks_[i >> kBits][i & (kChunk - 1)]; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

 private:
  static constexpr std::size_t kBits = 12, kChunk = std::size_t{1} << kBits;
  std::vector<std::vector<T>> chunks_;
  std::size_t size_ = 0;
};

}  // namespace xview
