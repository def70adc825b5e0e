// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace xview {

/// Something outside the program is not as it should be: a file, a disk, a poses list. The message
/// is one line and says path, place, what was expected and what was found. Ends a command with exit
/// code 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// "path: what" or, with a place, "path:place: what".
  Error(const std::string& path, const std::string& what)
      : std::runtime_error(path + ": " + what) {}
};

/// The caller asked for something impossible: an unknown option, a value out of range. Ends a
/// command with exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace xview
