// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

/// From now on what libraries print on standard error while a QuietLibraries lives is lost: they
/// repeat there what becomes an error of our own, in words and lines of theirs. For programs that
/// own their standard error and print there with printToUser() only; else nothing is done.
void allowQuietLibraries();

/// May live in several threads at a time.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
};

/// Prints on standard error, also while libraries cannot.
void printToUser(const std::string& text);

}  // namespace xview
