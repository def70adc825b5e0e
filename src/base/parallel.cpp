// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <future>
#include <vector>

#include "xview/base/budget.h"

namespace xview {
namespace {

#ifdef __SANITIZE_THREAD__
/// In place of TBB, which is not compiled with ThreadSanitizer: races would be seen in it.
void callAtOnce(int times, const std::function<void()>& call) {
  std::vector<std::future<void>> runs;  // their destructors wait
  for (int t = 0; t < times; ++t) runs.push_back(std::async(std::launch::async, call));
  for (std::future<void>& run : runs) run.get();
}
void isolated(const std::function<void()>& work) { work(); }
class Beside {
 public:
  void start(const std::function<void()>& call) { run_ = std::async(std::launch::async, call); }
  void wait() { run_.get(); }

 private:
  std::future<void> run_;  ///< its destructor waits
};
#else
// Without arenas or threads of their own: TBB 2021 keeps 7 kB of each of them for ever.

/// TBB may run foreign tasks while a thread waits; isolated, none of them needs a lock that this
/// thread holds.
void isolated(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }

void callAtOnce(int times, const std::function<void()>& call) {
  isolated([&] {
    tbb::parallel_for(
        0, times, [&](int) { call(); }, tbb::simple_partitioner());
  });
}

/// A call that is made while its caller goes on, within one isolated().
class Beside {
 public:
  ~Beside() { group_.wait(); }
  void start(const std::function<void()>& call) { group_.run(call); }
  void wait() { group_.wait(); }

 private:
  tbb::task_group group_;
};
#endif

/// Indices that a thread takes at a time, so that all have work until the end.
std::size_t portionOf(std::size_t count, int threads) {
  constexpr std::size_t kPortions = 32;  // per thread
  return std::max<std::size_t>(1, count / (kPortions * static_cast<std::size_t>(threads)));
}

void runLoop(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const std::size_t portion = portionOf(count, threads);
  std::atomic<std::size_t> next{0};
  callAtOnce(threads, [&] {
    try {
      for (std::size_t first = next.fetch_add(portion); first < count;
           first = next.fetch_add(portion)) {
        for (std::size_t i = first; i < std::min(first + portion, count); ++i) body(i);
      }
    } catch (...) {
      next = count;  // nobody needs the rest
      throw;
    }
  });
}

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
  isolated([&] {
    Beside making;
    for (std::size_t first = 0; first < count; first += batch) {
      if (first == 0 || !overlaps)
        makeBatch(first);
      else
        making.wait();
      if (overlaps) making.start([&, next = first + batch] { makeBatch(next); });
      for (std::size_t i = first; i < std::min(first + batch, count); ++i) {
        if (problems[i]) std::rethrow_exception(problems[i]);
        take(i);
      }
    }
  });
}

}  // namespace xview
