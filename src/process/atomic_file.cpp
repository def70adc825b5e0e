// SPDX-License-Identifier: BSD-3-Clause
#include "process/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "unfinished.h"
#include "xview/base/error.h"

namespace xview {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

/// Follows symbolic links, so that a link to a map stays a link; also to a target that does not
/// exist yet.
std::string resolveLinks(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, failed);
  return failed ? path : resolved.string();
}

}  // namespace

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), target_path_(resolveLinks(path_)), temporary_path_(target_path_) {
  struct stat old = {};
  const bool exists = stat(target_path_.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) throw Error(path_, "cannot write: it is a folder");
  if (exists && access(target_path_.c_str(), W_OK) != 0) fail("cannot write");
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  if (exists && !S_ISREG(old.st_mode))
    descriptor_ = open(target_path_.c_str(), O_WRONLY | O_CLOEXEC);
  else
    openBeside();
  if (descriptor_ < 0 && errno == ENOENT && !folder.empty() && access(folder.c_str(), F_OK) != 0)
    throw Error(path_, "cannot write: there is no folder " + folder + "; make it first");
  if (descriptor_ < 0) fail("cannot write");
  if (exists && S_ISREG(old.st_mode)) {
    (void)fchmod(descriptor_, old.st_mode & 07777);  // a file system without modes is no failure
  }
}

/// Under a name that nobody has taken, or planted.
void AtomicFile::openBeside() {
  constexpr int kTries = 100;
  removeAbandoned(target_path_);
  for (int i = 0; i < kTries; ++i) {
    temporary_path_ = partialNameFor(target_path_);
    addUnfinished(temporary_path_);
    descriptor_ = open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) return;
    const int problem = errno;
    dropUnfinished(temporary_path_);
    errno = problem;
    if (problem != EEXIST) return;
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  if (temporary_path_ == target_path_) return;
  unlink(temporary_path_.c_str());
  dropUnfinished(temporary_path_);
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
  dropUnfinished(temporary_path_);
  close(descriptor_);
  descriptor_ = -1;
}

void AtomicFile::keepSoFar() {
  const UninterruptedWrite whole;
  flush();
  if (temporary_path_ != target_path_) keepUnfinished(temporary_path_, target_path_);
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

// ---- folders

AtomicFolder::AtomicFolder(std::string path) : path_(std::move(path)) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  const std::string given = path_;
  path_ = resolveLinks(path_);
  std::error_code problem;
  const fs::file_status old = fs::status(path_, problem);
  if (fs::exists(old) && !fs::is_directory(old))
    throw Error(given, "cannot write: it is no folder");
  // Of several folders that are missing the topmost one appears, with the others in it.
  fs::path below;
  for (root_ = path_; !fs::exists(root_);) {
    const fs::path above = fs::path(root_).parent_path();
    if (above.empty() || fs::exists(above)) break;
    below = fs::path(root_).filename() / below;
    root_ = above.string();
  }
  const std::string beside = fs::exists(old) ? path_ + "/.new" : root_;
  removeAbandoned(beside);
  stage_ = partialNameFor(beside);
  new_ = (fs::path(stage_ + "/new") / below).string();
  while (new_.back() == '/') new_.pop_back();
  addUnfinished(stage_);
  fs::create_directories(new_, problem);
  if (!problem) return;
  dropUnfinished(stage_);
  throw Error(given, "cannot write: " + problem.message());
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  fs::remove_all(stage_, ignored);
  dropUnfinished(stage_);
}

void AtomicFolder::commit(const std::vector<std::string>& parts) {
  try {
    if (!fs::exists(root_)) return fs::rename(stage_ + "/new", root_);
    fs::create_directories(path_);
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) moveAway(*part);
    std::vector<std::string> others;
    for (const auto& entry : fs::directory_iterator(new_)) {
      const std::string name = entry.path().filename().string();
      if (std::find(parts.begin(), parts.end(), name) == parts.end()) others.push_back(name);
    }
    for (const std::string& name : others) replace(name);
    for (const std::string& part : parts) {
      if (fs::exists(new_ + "/" + part)) replace(part);
    }
  } catch (const fs::filesystem_error& e) {
    throw Error(path_, "cannot replace what is there: " + e.code().message());
  }
}

void AtomicFolder::replace(const std::string& name) {
  if (fs::is_directory(path_ + "/" + name)) moveAway(name);
  fs::rename(new_ + "/" + name, path_ + "/" + name);
}

/// To be removed with the rest.
void AtomicFolder::moveAway(const std::string& name) {
  if (!fs::exists(fs::symlink_status(path_ + "/" + name))) return;
  fs::create_directories(stage_ + "/old");
  fs::rename(path_ + "/" + name, stage_ + "/old/" + name);
}

void writeFile(const std::string& path, const void* data, std::size_t bytes) {
  AtomicFile file(path);
  file.write(data, bytes);
  file.commit();
}

bool makeFolder(const std::string& path) {
  std::error_code problem;
  if (path.empty()) return false;
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
