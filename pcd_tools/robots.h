// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "answer.h"
#include "clock.h"
#include "inputs.h"
#include "live.h"

namespace xview::tools {

/// A map in memory, with what finds queries in it.
struct LoadedMap {
  LoadedMap(map::SemanticMap loaded, const Job& given, const ClassNames& names, double load_ms);
  ~LoadedMap() { --count; }
  LoadedMap(const LoadedMap&) = delete;
  LoadedMap& operator=(const LoadedMap&) = delete;

  const map::SemanticMap map;
  Job job;  ///< of a request
  const Localizer localizer;
  Answer unanswered;                        ///< with what all answers share
  inline static std::atomic<int> count{0};  ///< that are in memory
};

/// A robot that is followed.
struct Robot {
  std::mutex mutex;  ///< its frames are taken one after the other
  std::shared_ptr<const LoadedMap> map;
  std::optional<Follower> follower;  ///< in that map
  std::int64_t frames = 0;
  Clock::time_point last = Clock::now();

  void followIn(const std::shared_ptr<const LoadedMap>& current);
  void letGo();
};

/// All that are followed; the one that was silent longest is forgotten for another one.
class Robots {
 public:
  std::shared_ptr<Robot> named(const std::string& id);
  /// False if nobody of this name is followed. A frame that is at work is answered still.
  bool forget(const std::string& id);
  /// Those that are followed in another map than this one are not followed any longer, so that the
  /// memory of an old map is freed; their next frames are looked for in the new one. A robot
  /// whose frame is at work stays until another call.
  void letGoOfOthersThan(const std::shared_ptr<const LoadedMap>& current);

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Robot>> robots_;
};

}  // namespace xview::tools
