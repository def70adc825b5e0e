// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/budget.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/parallel.h"
#include "support/sanitizers.h"
#include "xview/base/error.h"

namespace xview {
namespace {

rlim_t memoryBound() {
  rlimit bound{};
  getrlimit(RLIMIT_DATA, &bound);
  return bound.rlim_cur;
}

void take100Megabytes() {
  std::vector<char> large(100 << 20, 1);
  volatile char used = large[large.size() / 2];
  (void)used;
}

void askOften() {
  for (int i = 0; i < 1000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    askBudget("the test");
  }
}

TEST(Budgets, WithoutLimitsNothingIsCut) {
  const Budget budget({});
  EXPECT_FALSE(cutByBudget([] { askBudget("the test"); }));
  EXPECT_EQ(budget.exhausted(), "");
  EXPECT_THROW(cutByBudget([] { throw std::bad_alloc(); }), std::bad_alloc);
}

TEST(Budgets, TimeEndsOnAllThreadsAndStaysSpent) {
  for (const int threads : {1, 2}) {
    const Budget budget({0.02, 0});
    const auto cut = cutByBudget([&] { parallelFor(4, threads, [](std::size_t) { askOften(); }); });
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->status, Status::rejected);
    EXPECT_TRUE(cut->hypotheses.empty());
    EXPECT_EQ(cut->reason, "the time of 0.02 s ended in the test; nothing was decided");
    EXPECT_EQ(budget.exhausted(), "time");
    EXPECT_THROW(askBudget("another stage"), BudgetExhausted);
    EXPECT_TRUE(isBudgetSpent());
  }
  EXPECT_FALSE(isBudgetSpent());
  EXPECT_NO_THROW(askBudget("the test"));
}

TEST(Budgets, TimeEndsWhereThingsAreMadeInOrder) {
  const Budget budget({0.02, 0});
  const auto cut = cutByBudget([] {
    makeInOrder(
        8, 2, 2, [](std::size_t) { askOften(); }, [](std::size_t) {});
  });
  EXPECT_TRUE(cut);
}

TEST(Budgets, MemoryEndsOnAllThreadsAndItsBoundIsPutBack) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer ends a program without memory";
  const rlim_t before = memoryBound();
  for (const int threads : {1, 2}) {
    const Budget budget({0, 50});
    EXPECT_LT(memoryBound(), before);
    askBudget("the test");
    const auto cut =
        cutByBudget([&] { parallelFor(4, threads, [](std::size_t) { take100Megabytes(); }); });
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->reason, "the memory of 50 MB ended in the test; nothing was decided");
    EXPECT_EQ(budget.exhausted(), "memory");
    EXPECT_THROW(askBudget("another stage"), BudgetExhausted);
  }
  EXPECT_EQ(memoryBound(), before);
  EXPECT_NO_THROW(take100Megabytes());
}

TEST(Budgets, ThatBoundMemoryAtTheSameTimeAddUp) {
  const rlim_t before = memoryBound();
  {
    const Budget one({0, 100});
    const rlim_t of_one = memoryBound();
    std::thread([&] {
      const Budget another({0, 50});
      EXPECT_EQ(memoryBound(), of_one + (50 << 20));
    }).join();
    EXPECT_EQ(memoryBound(), of_one);
  }
  EXPECT_EQ(memoryBound(), before);
}

/// Check fix for: the one that ended last put another in force again that had ended before.
TEST(Budgets, EndInAnyOrder) {
  const rlim_t before = memoryBound();
  auto outer = std::make_unique<Budget>(BudgetLimits{100, 0});
  auto unlimited = std::make_unique<Budget>(BudgetLimits{});
  auto inner = std::make_unique<Budget>(BudgetLimits{1e-9, 1000});
  outer.reset();
  EXPECT_THROW(askBudget("the test"), BudgetExhausted) << "the inner one is still in force";
  inner.reset();
  EXPECT_NO_THROW(askBudget("the test"));
  EXPECT_FALSE(isBudgetSpent());
  unlimited.reset();
  EXPECT_EQ(BudgetOfThread::current(), nullptr);
  EXPECT_EQ(memoryBound(), before);
}

TEST(Budgets, LetOtherProblemsPass) {
  const Budget budget({100, 1000});
  EXPECT_THROW(cutByBudget([] { throw std::runtime_error("no such file"); }), std::runtime_error);
  EXPECT_EQ(budget.exhausted(), "");
  EXPECT_TRUE(
      cutByBudget([] { throw Error("a.png", "its pixels need more memory than there is"); }));
  EXPECT_EQ(budget.exhausted(), "memory");
}

TEST(Budgets, OfNegativeOrNoNumbersAreRefused) {
  EXPECT_THROW(Budget({-1, 0}), UsageError);
  EXPECT_THROW(Budget({0, -1}), UsageError);
  EXPECT_THROW(Budget({NAN, 0}), UsageError);
}

}  // namespace
}  // namespace xview
