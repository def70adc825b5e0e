// SPDX-License-Identifier: BSD-3-Clause
#include "xview/map/map_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

namespace xview {

// SQLite locks with fcntl(), which flock() does not meet; its locks are those of one transaction.
MapLock::MapLock(const std::string& path) : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) return;
  while (flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

MapLock::~MapLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace xview
