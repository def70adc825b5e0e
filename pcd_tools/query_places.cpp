// SPDX-License-Identifier: BSD-3-Clause
#include "query_places.h"

#include <algorithm>
#include <chrono>

#include "connection.h"

namespace xview::tools {

QueryPlaces::Place::Place(QueryPlaces& places, double most_s) : places_(places) {
  std::unique_lock<std::mutex> lock(places.mutex_);
  const auto has_room = [&] { return static_cast<int>(places.begun_.size()) < places.count_; };
  if (!places.changed_.wait_for(lock, std::chrono::duration<double>(most_s), has_room))
    throw Refusal{503, "busy: no query ended in time"};
  begin_ = places.begun_.insert(places.begun_.end(), Clock::now());
}

QueryPlaces::Place::~Place() {
  const std::lock_guard<std::mutex> lock(places_.mutex_);
  places_.begun_.erase(begin_);
  places_.changed_.notify_one();
}

QueryPlaces::Load QueryPlaces::load(double most_s) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Load load;
  load.places = count_;
  for (const Clock::time_point begun : begun_) {
    const double seconds = secondsSince(begun);
    ++load.running;
    load.stuck += seconds > most_s ? 1 : 0;
    load.longest_s = std::max(load.longest_s, seconds);
  }
  return load;
}

const char* QueryPlaces::Load::status() const {
  if (stuck > 0) return "stuck";
  return running < places ? "ok" : "busy";
}

}  // namespace xview::tools
