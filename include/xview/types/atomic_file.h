// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace xview {

/// An output file that appears whole or not at all: bytes go to a file beside the target, commit()
/// puts it in place. An object that goes without commit() leaves nothing behind and the old file
/// untouched, also (up to 64 at a time) if the program is interrupted after it called
/// removeUnfinishedOnInterrupt(). A symbolic link is followed; a target that exists and is no
/// regular file (/dev/full, a pipe) is written directly, since replacing it would destroy it.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);  ///< throws Error if the target cannot be written
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t bytes);  ///< throws Error, e.g. on a full disk
  void write(const std::string& text);
  void commit();  ///< throws Error; the target is then unchanged

  /// The file beside the target, for libraries that write by name; it exists and is empty until
  /// something is written.
  const std::string& temporaryPath() const { return temporary_path_; }

 private:
  void flush();
  [[noreturn]] void fail(const std::string& action) const;

  std::string path_;            ///< as given, for messages
  std::string target_path_;     ///< with links resolved
  std::string temporary_path_;  ///< equals target_path_ if written directly
  int slot_ = -1;               ///< among the unfinished files; -1: none was free
  std::string buffer_;
  int descriptor_ = -1;
};

/// From now on interrupt, hang-up and termination remove unfinished files before they end the
/// program, unless they are ignored.
void removeUnfinishedOnInterrupt();

/// Writes a file in one go. Throws Error.
void writeFile(const std::string& path, const void* data, std::size_t bytes);
template <class Bytes>
void writeFile(const std::string& path, const Bytes& bytes) {
  writeFile(path, bytes.data(), bytes.size() * sizeof(*bytes.data()));
}

/// Makes a folder and those above it; true if it was missing. Throws Error.
bool makeFolder(const std::string& path);

/// What cannot be written should be known before the work, not after it: throws what AtomicFile
/// would throw. An empty path is none, and a pipe is not tried.
void requireWritable(const std::string& path);

}  // namespace xview
