// SPDX-License-Identifier: BSD-3-Clause
#include "scratch_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "xview/base/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnknown = "XXXXXX";  ///< letters that mkdtemp chooses

/// A folder that is none, or a link to one, is not opened.
int openFolder(const std::string& path) {
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

/// False while another program holds the lock. Where there are no locks nothing is ever abandoned.
bool takeLock(int folder) { return flock(folder, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }

bool isOwn(int folder) {
  struct stat there = {};
  return fstat(folder, &there) == 0 && there.st_uid == geteuid() && (there.st_mode & 0777) == 0700;
}

/// Files only, and only such as makeFile() names; a folder with anything else in it stays.
void removeWithFiles(int folder, const std::string& path) {
  std::vector<std::string> names;
  if (DIR* const listing = fdopendir(dup(folder))) {
    while (const dirent* const entry = readdir(listing)) names.emplace_back(entry->d_name);
    closedir(listing);
  }
  for (const std::string& name : names) {
    if (std::isdigit(static_cast<unsigned char>(name[0])) != 0) unlinkat(folder, name.c_str(), 0);
  }
  rmdir(path.c_str());
}

}  // namespace

ScratchFolder::ScratchFolder(std::string name)
    : name_((fs::temp_directory_path() / (std::move(name) + "-")).string()) {
  make();
  removeAbandoned();
}

/// What is made may be taken for abandoned until it is locked.
void ScratchFolder::make() {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    path_ = name_ + kUnknown;
    if (mkdtemp(path_.data()) == nullptr)
      throw Error(path_, std::string("cannot be made: ") + std::strerror(errno) +
                             "; is TMPDIR a folder that can be written?");
    if (folder_ >= 0) close(folder_);
    folder_ = openFolder(path_);
    if (folder_ >= 0 && takeLock(folder_) && isThere()) return;
  }
  throw Error(path_, "cannot be locked");
}

/// The folder that is open, and not another one of its name.
bool ScratchFolder::isThere() const {
  struct stat ours = {}, there = {};
  return fstat(folder_, &ours) == 0 && lstat(path_.c_str(), &there) == 0 &&
         ours.st_dev == there.st_dev && ours.st_ino == there.st_ino;
}

ScratchFolder::File ScratchFolder::makeFile() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!isThere()) make();
  const std::string name = std::to_string(count_++);
  const int file =
      openat(folder_, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (file < 0)
    throw Error(path_ + "/" + name, std::string("cannot be made: ") + std::strerror(errno));
  return {file, path_ + "/" + name};
}

void ScratchFolder::remove() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (folder_ < 0 || !isThere()) return;
  removeWithFiles(folder_, path_);
}

void ScratchFolder::removeAbandoned() const {
  std::error_code failed;
  for (fs::directory_iterator entry(fs::path(name_).parent_path(), failed), end;
       !failed && entry != end; entry.increment(failed)) {
    const std::string path = entry->path().string();
    if (path.rfind(name_, 0) != 0 || path.size() != name_.size() + std::strlen(kUnknown)) continue;
    const int folder = openFolder(path);
    if (folder < 0) continue;
    if (isOwn(folder) && flock(folder, LOCK_EX | LOCK_NB) == 0) removeWithFiles(folder, path);
    close(folder);
  }
}

}  // namespace xview::tools
