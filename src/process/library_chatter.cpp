// SPDX-License-Identifier: BSD-3-Clause
#include "process/library_chatter.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <mutex>

namespace xview {
namespace {

struct StandardError {
  std::mutex mutex;
  bool allowed = false;
  int quiet = 0;  ///< objects that live
  int user = -1;  ///< where the user reads, while libraries are quiet
};
StandardError& standardError() {
  static auto* const one = new StandardError;  // threads may print until the program has ended
  return *one;
}
using Lock = std::lock_guard<std::mutex>;

void writeAll(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = write(descriptor, text.data() + done, text.size() - done);
    if (written < 0 && errno != EINTR) return;  // whom could that be told
    if (written > 0) done += static_cast<std::size_t>(written);
  }
}

}  // namespace

void allowQuietLibraries() {
  StandardError& all = standardError();
  const Lock lock(all.mutex);
  all.allowed = true;
}

QuietLibraries::QuietLibraries() {
  StandardError& all = standardError();
  const Lock lock(all.mutex);
  if (!all.allowed || all.quiet++ > 0) return;
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return;
  std::fflush(stderr);
  all.user = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (all.user >= 0) dup2(nowhere, STDERR_FILENO);
  close(nowhere);
}

QuietLibraries::~QuietLibraries() {
  StandardError& all = standardError();
  const Lock lock(all.mutex);
  if (!all.allowed || --all.quiet > 0 || all.user < 0) return;
  std::fflush(stderr);
  dup2(all.user, STDERR_FILENO);
  close(all.user);
  all.user = -1;
}

void printToUser(const std::string& text) {
  StandardError& all = standardError();
  const Lock lock(all.mutex);
  std::fflush(stderr);
  writeAll(all.user >= 0 ? all.user : STDERR_FILENO, text);
}

}  // namespace xview
