// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

/// Held from reading a map to writing it back, so that two programs that add to it at one time add
/// one after the other, and neither loses what the other added. The constructor waits for whoever
/// holds it. A map that does not exist or lies on a file system without locks is not held.
/// Reading a map needs no lock.
class MapLock {
 public:
  explicit MapLock(const std::string& path);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace xview
