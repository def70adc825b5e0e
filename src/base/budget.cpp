// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/budget.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <mutex>
#include <new>
#include <sstream>
#include <system_error>

#include "xview/base/error.h"

namespace xview {
namespace {

thread_local Budget* t_budget = nullptr;

/// Private writable memory of the process [bytes].
rlim_t bytesOfProcess() {
  std::ifstream file("/proc/self/statm");
  rlim_t pages = 0;
  for (int field = 0; field < 6; ++field) file >> pages;
  if (!file) throw Error("/proc/self/statm", "cannot be read, so memory cannot be bounded");
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

/// The bound of the process: what it had when the first of the bounded queries began, and what they
/// may all take.
class ProcessBound {
 public:
  void add(double memory_mb) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (queries_ == 0) {
      getrlimit(RLIMIT_DATA, &before_);
      bytes_ = bytesOfProcess();
    }
    ++queries_;
    bytes_ += bytesOf(memory_mb);
    set(bytes_);
  }
  void remove(double memory_mb) {
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes_ -= bytesOf(memory_mb);
    set(--queries_ > 0 ? bytes_ : before_.rlim_cur);
  }

 private:
  static rlim_t bytesOf(double mb) { return static_cast<rlim_t>(mb * (1 << 20)); }
  void set(rlim_t bytes) const {
    const rlimit bound{std::min(bytes, before_.rlim_cur), before_.rlim_max};
    setrlimit(RLIMIT_DATA, &bound);
  }

  std::mutex mutex_;
  int queries_ = 0;
  rlim_t bytes_ = 0;
  rlimit before_{};
};

ProcessBound& processBound() {
  static auto* const one = new ProcessBound;
  return *one;
}

/// Libraries, and readers that name their file, say in words of their own that there is no memory.
bool speaksOfMemory(const std::string& message) {
  for (const char* words :
       {"Insufficient memory", "memory than there is", "out of memory", "annot allocate memory",
        "failed to map segment", "pthread_create has failed"})  // TBB: no room for a stack
    if (message.find(words) != std::string::npos) return true;
  return false;
}

}  // namespace

void requireValid(const BudgetLimits& limits) {
  constexpr double kMost = 1e9;
  if (!(limits.time_s >= 0 && limits.time_s <= kMost))
    throw UsageError("timeout = " + std::to_string(limits.time_s) + ", must be in [0, 1e9] s");
  if (!(limits.memory_mb >= 0 && limits.memory_mb <= kMost))
    throw UsageError("max-memory = " + std::to_string(limits.memory_mb) +
                     ", must be in [0, 1e9] MB");
}

Budget::Budget(const BudgetLimits& limits) : limits_(limits), around_(t_budget) {
  requireValid(limits);
  if (limits_.memory_mb > 0) processBound().add(limits_.memory_mb);
  if (limits_.any()) t_budget = this;
}

/// Those that were made later may still be in force, and must forget this one.
Budget::~Budget() {
  Budget** in_force = &t_budget;
  while (*in_force != nullptr && *in_force != this) in_force = &(*in_force)->around_;
  if (*in_force == this) *in_force = around_;
  if (limits_.memory_mb > 0) processBound().remove(limits_.memory_mb);
}

void Budget::ask(const char* stage) {
  const std::chrono::duration<double> spent = Clock::now() - begin_;
  if (*exhausted_.load() == 0) {
    stage_ = stage;
    if (limits_.time_s > 0 && spent.count() > limits_.time_s) exhausted_ = "time";
  }
  if (*exhausted_.load() != 0) throw BudgetExhausted();
}

Localization Budget::cut() {
  Localization answer;
  const bool is_time = exhausted() == "time";
  std::ostringstream reason;
  reason << "the " << exhausted() << " of " << (is_time ? limits_.time_s : limits_.memory_mb)
         << (is_time ? " s" : " MB") << " ended in " << stage_.load() << "; nothing was decided";
  answer.reason = reason.str();
  answer.reason_code = ReasonCode::budget_exhausted;
  const std::chrono::duration<double, std::milli> spent = Clock::now() - begin_;
  answer.timing_ms.emplace_back("total", spent.count());
  return answer;
}

void askBudget(const char* stage) {
  if (t_budget) t_budget->ask(stage);
}

std::string exhaustedBudget() { return t_budget ? t_budget->exhausted() : ""; }

std::optional<Localization> cutByBudget(const std::function<void()>& work) {
  Budget* const budget = t_budget;
  if (!budget) {
    work();
    return std::nullopt;
  }
  const bool is_bounded = budget->limits_.memory_mb > 0;
  try {
    work();
    return std::nullopt;
  } catch (const BudgetExhausted&) {
  } catch (const std::bad_alloc&) {
    if (!is_bounded) throw;
    budget->exhausted_ = "memory";
  } catch (const std::system_error& e) {  // a thread needs memory for its stack
    if (!is_bounded || e.code() != std::errc::resource_unavailable_try_again) throw;
    budget->exhausted_ = "memory";
  } catch (const std::exception& e) {
    if (!is_bounded || !speaksOfMemory(e.what())) throw;
    budget->exhausted_ = "memory";
  }
  return budget->cut();
}

Localization withinBudget(const std::function<Localization()>& find) {
  Localization answer;
  const auto cut = cutByBudget([&] { answer = find(); });
  return cut ? *cut : answer;
}

Budget* BudgetOfThread::current() { return t_budget; }
BudgetOfThread::BudgetOfThread(Budget* budget) : before_(t_budget) { t_budget = budget; }
BudgetOfThread::~BudgetOfThread() { t_budget = before_; }

}  // namespace xview
