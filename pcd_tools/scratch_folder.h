// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <mutex>
#include <string>

namespace xview::tools {

/// A folder for files that nobody else may read or plant, within the folder for such things of the
/// system, which all users share. Its name cannot be foretold; it is locked while the object
/// lives, and what killed programs of the same user left, which is not, is removed. If somebody
/// removes it, another one is made.
class ScratchFolder {
 public:
  explicit ScratchFolder(std::string name);  ///< throws Error
  ~ScratchFolder() { remove(); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  struct File {
    int descriptor;
    std::string path;
  };
  File makeFile();  ///< to be closed and removed by the caller; throws Error
  void remove();

 private:
  bool isThere() const;
  void make();
  void removeAbandoned() const;

  std::string name_;  ///< with which paths begin
  std::string path_;
  std::mutex mutex_;
  int folder_ = -1;  ///< descriptor
  std::uint64_t count_ = 0;
};

}  // namespace xview::tools
