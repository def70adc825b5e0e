// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace xview {
namespace {

TEST(ParallelFor, CallsEveryIndexOnceForAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 7}) {
    for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
      std::vector<std::atomic<int>> calls(count);
      parallelFor(count, threads, [&](std::size_t i) { ++calls[i]; });
      for (const auto& number : calls) EXPECT_EQ(number.load(), 1);
    }
  }
}

TEST(ParallelFor, RethrowsWhatABodyThrows) {
  for (const int threads : {1, 2}) {
    EXPECT_THROW(parallelFor(100, threads,
                             [](std::size_t i) {
                               if (i == 57) throw std::runtime_error("57");
                             }),
                 std::runtime_error);
  }
}

TEST(ParallelFor, MayBeNested) {
  std::atomic<int> calls{0};
  parallelFor(8, 2, [&](std::size_t) { parallelFor(8, 2, [&](std::size_t) { ++calls; }); });
  EXPECT_EQ(calls.load(), 64);
}

}  // namespace
}  // namespace xview
