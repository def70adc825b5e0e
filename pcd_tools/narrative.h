// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <set>
#include <string>

#include "xview/mapper.h"

namespace xview::tools {

enum class Verbosity { quiet, normal, verbose };

/// What the program tells people on stderr while it works; results go to stdout.
class Narrative {
 public:
  explicit Narrative(Verbosity verbosity = Verbosity::normal)
      : verbosity_(verbosity), noted_(std::make_shared<std::set<std::string>>()) {}

  /// "[map] 12 ms, 4512 points"
  void stage(const std::string& name, double ms, const std::string& what) const;
  /// Something to know that is no error; "note: …". Said once, however often it is noted.
  void note(const std::string& what) const;
  /// Only with --verbose.
  void detail(const std::string& what) const;
  /// "error: …", also with --quiet, for one item of a batch whose rest goes on.
  void error(const std::string& what) const;
  /// A bar with rate and time left; empty if stderr is no terminal or the user wants quiet.
  Progress progress(const std::string& name) const;

 private:
  Verbosity verbosity_;
  std::shared_ptr<std::set<std::string>> noted_;
};

/// The text without line breaks, so that every message is one line.
std::string oneLine(std::string text);

}  // namespace xview::tools
