// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/unfinished_file.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <utility>

namespace xview {
namespace {

// A signal handler may read these and call unlink, but neither lock nor allocate.
std::array<std::atomic<const char*>, 64> unfinished_paths{};

int occupySlot(const char* path) {
  for (std::size_t i = 0; i < unfinished_paths.size(); ++i) {
    const char* free = nullptr;
    if (unfinished_paths[i].compare_exchange_strong(free, path)) return static_cast<int>(i);
  }
  return -1;
}

void removeAndEnd(int signal) {
  for (const auto& path : unfinished_paths) {
    if (const char* name = path.load()) unlink(name);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

UnfinishedFile::UnfinishedFile(std::string path)
    : path_(std::move(path)), slot_(occupySlot(path_.c_str())) {}

UnfinishedFile::~UnfinishedFile() {
  if (slot_ >= 0) unfinished_paths[static_cast<std::size_t>(slot_)] = nullptr;
}

void removeUnfinishedOnInterrupt() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, removeAndEnd) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

}  // namespace xview
