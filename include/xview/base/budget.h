// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <string>

#include "xview/base/localization.h"

namespace xview {

/// What a query may take; 0 = as much as it needs.
struct BudgetLimits {
  double time_s = 0;
  double memory_mb = 0;  ///< beyond what the process has when the query begins, see Budget
  bool any() const { return time_s > 0 || memory_mb > 0; }
};

/// Throws UsageError if a limit is negative or no number.
void requireValid(const BudgetLimits& limits);

/// A bound of the query was reached.
struct BudgetExhausted : std::exception {
  const char* what() const noexcept override { return "a bound of the query was reached"; }
};

/// Bounds the query that is made and answered while the object lives: on the thread that made it
/// and on threads that work for that one (parallelFor, makeInOrder). Who answers queries looks at
/// it with askBudget() now and then; a Localizer turns what that throws into an answer that is
/// rejected, says where it was cut, and has no hypothesis. Memory is bounded by the operating
/// system for the whole process (RLIMIT_DATA): bounds of queries that run at the same time add up.
/// It ends on the thread that made it; of several the order does not matter.
class Budget {
 public:
  /// Without limits nothing changes: a bound around this one stays in force. Throws UsageError, and
  /// Error if the memory of the process cannot be bounded.
  explicit Budget(const BudgetLimits& limits);
  ~Budget();
  Budget(const Budget&) = delete;
  Budget& operator=(const Budget&) = delete;

  /// "time" or "memory" once that bound was reached, so that something was cut; else empty.
  std::string exhausted() const { return exhausted_.load(); }

 private:
  friend void askBudget(const char* stage);
  friend std::optional<Localization> cutByBudget(const std::function<void()>& work);
  void ask(const char* stage);
  Localization cut();

  using Clock = std::chrono::steady_clock;
  BudgetLimits limits_;
  Clock::time_point begin_ = Clock::now();
  Budget* around_;                                 ///< that was in force before
  std::atomic<const char*> stage_{"the reading"};  ///< that asked last
  std::atomic<const char*> exhausted_{""};
};

/// Throws BudgetExhausted if the budget of the query is spent, from then on always. `stage`: what
/// is about to begin or to go on, "the search"; a literal.
void askBudget(const char* stage);

/// Budget::exhausted() of the query on this thread.
std::string exhaustedBudget();
inline bool isBudgetSpent() { return !exhaustedBudget().empty(); }

/// Does the work; if the budget of the query ends before it does, the answer that says so. What the
/// work made must not be used then. Without a budget all exceptions pass.
std::optional<Localization> cutByBudget(const std::function<void()>& work);

/// What `find` returns, or the answer that says what was cut.
Localization withinBudget(const std::function<Localization()>& find);

/// Puts the budget of one thread in force on another one that works for it.
class BudgetOfThread {
 public:
  static Budget* current();
  explicit BudgetOfThread(Budget* budget);
  ~BudgetOfThread();
  BudgetOfThread(const BudgetOfThread&) = delete;
  BudgetOfThread& operator=(const BudgetOfThread&) = delete;

 private:
  Budget* before_;
};

}  // namespace xview
