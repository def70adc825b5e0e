// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/parallel.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace xview {

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  // More threads than cores would only make TBB complain on stderr.
  const int cores = tbb::info::default_concurrency();
  tbb::task_arena arena(threads > 0 ? std::min(threads, cores) : cores);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body); });
}

namespace {

/// Hands out the numbers of items, no further than `ahead` beyond what was taken.
class InOrder {
 public:
  InOrder(std::size_t count, std::size_t ahead)
      : count_(count), ahead_(ahead), done_(ahead), problem_(ahead) {}

  /// Makes items until there are none left, or the caller has given up.
  void work(const std::function<void(std::size_t)>& make) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return gave_up_ || begun_ == count_ || mayBegin(); });
      if (gave_up_ || begun_ == count_) return;
      makeNext(make, lock);
    }
  }

  /// Takes all items in order; makes some, too, when the next one is not ready.
  void takeAll(const std::function<void(std::size_t)>& make,
               const std::function<void(std::size_t)>& take) {
    std::unique_lock<std::mutex> lock(mutex_);
    while (taken_ < count_) {
      if (done_[taken_ % ahead_])
        takeNext(take, lock);
      else if (mayBegin())
        makeNext(make, lock);
      else
        changed_.wait(lock);
    }
  }

  void giveUp() {
    const std::lock_guard<std::mutex> lock(mutex_);
    gave_up_ = true;
    changed_.notify_all();
  }

 private:
  bool mayBegin() const { return begun_ < count_ && begun_ < taken_ + ahead_; }

  void makeNext(const std::function<void(std::size_t)>& make, std::unique_lock<std::mutex>& lock) {
    const std::size_t i = begun_++;
    lock.unlock();
    std::exception_ptr problem;
    try {
      make(i);
    } catch (...) {
      problem = std::current_exception();
    }
    lock.lock();
    problem_[i % ahead_] = problem;
    done_[i % ahead_] = true;
    changed_.notify_all();
  }

  void takeNext(const std::function<void(std::size_t)>& take, std::unique_lock<std::mutex>& lock) {
    if (problem_[taken_ % ahead_]) std::rethrow_exception(problem_[taken_ % ahead_]);
    lock.unlock();
    take(taken_);
    lock.lock();
    done_[taken_ % ahead_] = false;
    ++taken_;
    changed_.notify_all();
  }

  const std::size_t count_, ahead_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t begun_ = 0, taken_ = 0;
  bool gave_up_ = false;
  std::vector<bool> done_;                   ///< per item modulo ahead_
  std::vector<std::exception_ptr> problem_;  ///< same
};

}  // namespace

void makeInOrder(std::size_t count, int threads, std::size_t ahead,
                 const std::function<void(std::size_t)>& make,
                 const std::function<void(std::size_t)>& take) {
  const int cores = tbb::info::default_concurrency();
  const std::size_t workers = std::min<std::size_t>(
      count, static_cast<std::size_t>(threads > 0 ? std::min(threads, cores) : cores));
  InOrder items(count, std::max<std::size_t>(ahead, 1));
  std::vector<std::thread> others;
  const auto finish = [&] {
    items.giveUp();
    for (std::thread& thread : others) thread.join();
  };
  try {
    for (std::size_t i = 1; i < workers; ++i) others.emplace_back([&] { items.work(make); });
    items.takeAll(make, take);
  } catch (...) {
    finish();
    throw;
  }
  finish();
}

}  // namespace xview
