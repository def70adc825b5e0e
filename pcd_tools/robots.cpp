// SPDX-License-Identifier: BSD-3-Clause
#include "robots.h"

#include <algorithm>
#include <utility>

namespace xview::tools {

constexpr std::size_t kMostRobots = 64;

LoadedMap::LoadedMap(map::SemanticMap loaded, const Job& given, const ClassNames& names,
                     double load_ms)
    : map(std::move(loaded)),
      job(inMap(given, map)),
      localizer(map::borrowed(map), job.options, names) {
  job.narrate = Narrative(Verbosity::quiet);
  unanswered = unansweredIn(map, given.operands[0], load_ms);
  ++count;
}

void Robot::followIn(const std::shared_ptr<const LoadedMap>& current) {
  if (map == current) return;
  follower.emplace(current->localizer);
  map = current;
}

void Robot::letGo() {
  follower.reset();  // before what it looks into
  map.reset();
}

std::shared_ptr<Robot> Robots::named(const std::string& id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::shared_ptr<Robot>& robot = robots_[id];
  if (!robot) robot = std::make_shared<Robot>();
  robot->last = Clock::now();
  const std::shared_ptr<Robot> wanted = robot;
  if (robots_.size() > kMostRobots)
    robots_.erase(std::min_element(
        robots_.begin(), robots_.end(),
        [](const auto& a, const auto& b) { return a.second->last < b.second->last; }));
  return wanted;
}

bool Robots::forget(const std::string& id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return robots_.erase(id) > 0;
}

void Robots::letGoOfOthersThan(const std::shared_ptr<const LoadedMap>& current) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [id, robot] : robots_) {
    const std::unique_lock<std::mutex> silent(robot->mutex, std::try_to_lock);
    if (silent && robot->map && robot->map != current) robot->letGo();
  }
}

}  // namespace xview::tools
