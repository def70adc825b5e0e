// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "xview/types/error.h"

namespace xview {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

/// Follows symbolic links, so that a link to a map stays a link; also to a target that does not
/// exist yet.
std::string resolveLinks(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, failed);
  return failed ? path : resolved.string();
}

/// A name of its own for every object of every process.
std::string nameBeside(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  return path + ".partial-" + std::to_string(getpid()) + "-" + std::to_string(counter++);
}

// A signal handler may read these and call unlink, but neither lock nor allocate.
std::array<std::atomic<const char*>, 64> unfinished_paths{};

int occupySlot(const char* path) {
  for (std::size_t i = 0; i < unfinished_paths.size(); ++i) {
    const char* free = nullptr;
    if (unfinished_paths[i].compare_exchange_strong(free, path)) return static_cast<int>(i);
  }
  return -1;
}

void freeSlot(int slot) {
  if (slot >= 0) unfinished_paths[static_cast<std::size_t>(slot)] = nullptr;
}

void removeAndEnd(int signal) {
  for (const auto& path : unfinished_paths) {
    if (const char* name = path.load()) unlink(name);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void removeUnfinishedOnInterrupt() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, removeAndEnd) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), target_path_(resolveLinks(path_)), temporary_path_(target_path_) {
  struct stat old = {};
  const bool exists = stat(target_path_.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) throw Error(path_, "cannot write: it is a folder");
  if (exists && access(target_path_.c_str(), W_OK) != 0) fail("cannot write");
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  if (exists && !S_ISREG(old.st_mode)) {
    descriptor_ = open(target_path_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    temporary_path_ = nameBeside(target_path_);
    slot_ = occupySlot(temporary_path_.c_str());
    descriptor_ = open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) freeSlot(slot_);
  }
  if (descriptor_ < 0 && errno == ENOENT && !folder.empty() && access(folder.c_str(), F_OK) != 0)
    throw Error(path_, "cannot write: there is no folder " + folder + "; make it first");
  if (descriptor_ < 0) fail("cannot write");
  if (exists && S_ISREG(old.st_mode)) {
    (void)fchmod(descriptor_, old.st_mode & 07777);  // a file system without modes is no failure
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  if (temporary_path_ != target_path_) unlink(temporary_path_.c_str());
  freeSlot(slot_);
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  buffer_.append(static_cast<const char*>(data), bytes);
  if (buffer_.size() >= kBufferBytes) flush();
}

void AtomicFile::write(const std::string& text) { write(text.data(), text.size()); }

void AtomicFile::commit() {
  flush();
  // Some file systems report a full disk only here. Devices and pipes cannot be synchronised.
  if (fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) fail("cannot write");
  if (temporary_path_ != target_path_ &&
      std::rename(temporary_path_.c_str(), target_path_.c_str()) != 0) {
    fail("cannot replace the old file");
  }
  freeSlot(slot_);
  close(descriptor_);
  descriptor_ = -1;
}

void AtomicFile::flush() {
  const char* next = buffer_.data();
  std::size_t left = buffer_.size();
  while (left > 0) {
    const ssize_t written = ::write(descriptor_, next, left);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write");
    next += written;
    left -= static_cast<std::size_t>(written);
  }
  buffer_.clear();
}

void AtomicFile::fail(const std::string& action) const {
  throw Error(path_, action + ": " + std::strerror(errno));
}

void writeFile(const std::string& path, const void* data, std::size_t bytes) {
  AtomicFile file(path);
  file.write(data, bytes);
  file.commit();
}

bool makeFolder(const std::string& path) {
  std::error_code problem;
  const bool is_new = std::filesystem::create_directories(path, problem);
  if (problem) throw Error(path, "cannot be made: " + problem.message());
  return is_new;
}

void requireWritable(const std::string& path) {
  struct stat old = {};
  // Who reads a pipe would see its end if it were opened and closed again.
  if (path.empty() || (stat(path.c_str(), &old) == 0 && S_ISFIFO(old.st_mode))) return;
  AtomicFile{path};
}

}  // namespace xview
