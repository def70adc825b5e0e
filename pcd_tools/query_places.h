// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <list>
#include <mutex>

#include "clock.h"

namespace xview::tools {

/// A limited number of queries is computed at a time; the others wait, but not for ever.
class QueryPlaces {
 public:
  void setCount(int count) { count_ = count; }

  /// The place of one query while it lives.
  class Place {
   public:
    Place(QueryPlaces& places, double most_s);  ///< throws Refusal if none was free for that long
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    QueryPlaces& places_;
    std::list<Clock::time_point>::iterator begin_;
  };

  struct Load {
    int running = 0, places = 0;
    int stuck = 0;         ///< of those that run
    double longest_s = 0;  ///< of the one that runs longest
    const char* status() const;
    /// No query is answered any more.
    bool isStuck() const { return stuck == places; }
  };
  /// `most_s`: what takes longer is stuck.
  Load load(double most_s) const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int count_ = 1;
  std::list<Clock::time_point> begun_;  ///< by those that run
};

}  // namespace xview::tools
