// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/parallel.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <future>
#include <vector>

#include "xview/types/budget.h"

namespace xview {
namespace {

#ifdef __SANITIZE_THREAD__
/// In place of TBB, which is not compiled with ThreadSanitizer: races would be seen in it.
void runLoop(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> runs;  // their ends wait
  for (int t = 0; t < threads; ++t) {
    runs.push_back(std::async(std::launch::async, [&] {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    }));
  }
  for (std::future<void>& run : runs) run.get();
}
#else
void runLoop(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body); });
}
#endif

}  // namespace

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  // More threads than cores would only make TBB complain on stderr.
  const int cores = tbb::info::default_concurrency();
  Budget* const budget = BudgetOfThread::current();
  runLoop(count, threads > 0 ? std::min(threads, cores) : cores, [&](std::size_t i) {
    const BudgetOfThread of_caller(budget);
    body(i);
  });
}

void makeInOrder(std::size_t count, int threads, std::size_t ahead,
                 const std::function<void(std::size_t)>& make,
                 const std::function<void(std::size_t)>& take) {
  // While one batch is taken the next one is made, so that each may have half of what is ahead.
  const std::size_t batch = std::max<std::size_t>(ahead / 2, 1);
  const bool overlaps = threads != 1 && ahead > 1 && tbb::info::default_concurrency() > 1;
  std::vector<std::exception_ptr> problems(count);
  Budget* const budget = BudgetOfThread::current();
  const auto makeBatch = [&](std::size_t first) {
    const BudgetOfThread of_caller(budget);
    const std::size_t size = first < count ? std::min(batch, count - first) : 0;
    parallelFor(size, threads, [&](std::size_t i) {
      try {
        make(first + i);
      } catch (...) {
        problems[first + i] = std::current_exception();
      }
    });
  };
  std::future<void> making;  // its end waits for the batch
  for (std::size_t first = 0; first < count; first += batch) {
    if (making.valid())
      making.get();
    else
      makeBatch(first);
    if (overlaps) making = std::async(std::launch::async, makeBatch, first + batch);
    for (std::size_t i = first; i < std::min(first + batch, count); ++i) {
      if (problems[i]) std::rethrow_exception(problems[i]);
      take(i);
    }
  }
}

}  // namespace xview
