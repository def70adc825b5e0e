// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <string>
#include <utility>

#include "process/helpers.h"
#include "xview/base/error.h"

namespace xview::test {

/// Helpers in this process, which answer what they were sent when they are asked for it. They are
/// shared with as long as they live.
template <class Helper>
class HelpersInOneProcess final : public Helpers {
 public:
  /// Each Helper is made of the arguments.
  template <class... Arguments>
  explicit HelpersInOneProcess(int count, const Arguments&... arguments) {
    while (static_cast<int>(helpers_.size()) < count) helpers_.emplace_back(arguments...);
    shareWork(this);
  }
  ~HelpersInOneProcess() override { shareWork(nullptr); }
  HelpersInOneProcess(const HelpersInOneProcess&) = delete;
  HelpersInOneProcess& operator=(const HelpersInOneProcess&) = delete;

  int count() const override { return static_cast<int>(helpers_.size()); }
  void send(int helper, const std::string& request) override {
    at(helper).waiting.push_back(request);
    bytes_ += request.size();
  }
  std::string receive(int helper) override {
    Seat& asked = at(helper);
    if (asked.waiting.empty()) throw Error("helper", "was not asked");
    const std::string request = std::move(asked.waiting.front());
    asked.waiting.pop_front();
    ++asked.answers;
    return asked.worker.answer(request);
  }

  const Helper& operator[](int helper) { return at(helper).worker; }
  int answersOf(int helper) { return at(helper).answers; }
  std::size_t takeBytes() { return std::exchange(bytes_, 0); }  ///< sent since it was asked last
  bool isWaitedFor() const {
    return std::any_of(helpers_.begin(), helpers_.end(),
                       [](const Seat& seat) { return !seat.waiting.empty(); });
  }

 private:
  struct Seat {
    template <class... Arguments>
    explicit Seat(const Arguments&... arguments) : worker(arguments...) {}

    Helper worker;
    std::deque<std::string> waiting;
    int answers = 0;
  };
  Seat& at(int helper) { return helpers_.at(static_cast<std::size_t>(helper)); }

  std::deque<Seat> helpers_;
  std::size_t bytes_ = 0;
};

}  // namespace xview::test
