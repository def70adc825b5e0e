// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace xview {

/// An output file that appears whole or not at all: bytes go to a file beside the target, commit()
/// puts it in place. An object that goes without commit() leaves nothing behind and the old file
/// untouched, also if the program is interrupted after it called removeUnfinishedOnInterrupt().
/// What a killed run left beside this target is removed. A symbolic link is followed; a target that
/// exists and is no regular file (/dev/full, a pipe) is written directly, since replacing it would
/// destroy it.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);  ///< throws Error if the target cannot be written
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t bytes);  ///< throws Error, e.g. on a full disk
  void write(const std::string& text);
  void commit();  ///< throws Error; the target is then unchanged

  /// For results that come one by one: if the program is interrupted from now on, what was written
  /// until the last call is put in place. Throws Error.
  void keepSoFar();

  /// The file beside the target, for libraries that write by name; it exists and is empty until
  /// something is written.
  const std::string& temporaryPath() const { return temporary_path_; }

 private:
  void openBeside();
  void flush();
  [[noreturn]] void fail(const std::string& action) const;

  std::string path_;            ///< as given, for messages
  std::string target_path_;     ///< with links resolved
  std::string temporary_path_;  ///< equals target_path_ if written directly
  std::string buffer_;
  int descriptor_ = -1;
};

/// An output folder that appears whole or not at all, in the same way: files are written to a
/// folder beside the target, or within it if it exists.
class AtomicFolder {
 public:
  explicit AtomicFolder(std::string path);  ///< throws Error if it cannot be made
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const std::string& temporaryPath() const { return new_; }  ///< an empty folder to write to

  /// Puts it in place. A target that exists keeps what has other names. Entries called as one of
  /// `parts` are taken away first, from the last to the first, and come last, from the first to
  /// the last: as long as it is not whole the target has no entry of the last name, by which its
  /// readers recognise it. Throws Error.
  void commit(const std::vector<std::string>& parts = {});

 private:
  void replace(const std::string& name);
  void moveAway(const std::string& name);

  std::string path_;   ///< with links resolved
  std::string root_;   ///< the topmost folder of the path that was missing, else the path
  std::string stage_;  ///< holds new_ and, while they are replaced, old entries
  std::string new_;
};

/// From now on interrupt, hang-up and termination remove unfinished files and folders, put the
/// results so far in place (AtomicFile::keepSoFar), and end the program with the exit code 128 +
/// number of the signal: 130, 129, 143. Signals that are ignored stay ignored. To be called before
/// the program starts threads, because they inherit what signals wait for.
void removeUnfinishedOnInterrupt();

/// What an interrupt calls before that, on a thread of its own: a server answers what is under way.
void finishOnInterrupt(std::function<void()> finish);

/// While one lives an interrupt waits, for up to two seconds, so that a result is written whole.
class UninterruptedWrite {
 public:
  UninterruptedWrite();
  ~UninterruptedWrite();
  UninterruptedWrite(const UninterruptedWrite&) = delete;
  UninterruptedWrite& operator=(const UninterruptedWrite&) = delete;
};

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
