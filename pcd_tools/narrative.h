// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/label_match.h"
#include "xview/base/localization.h"
#include "xview/mapper.h"

namespace xview::tools {

enum class Verbosity { quiet, normal, verbose };

/// Who hears notes and progress instead of those who read stderr: a program that calls this one as
/// a library. What its functions throw ends the work.
struct Audience {
  std::function<void(const std::string&)> note;
  Progress progress;
};

/// What the program tells people on stderr while it works; results go to stdout.
class Narrative {
 public:
  /// Says nothing on stderr.
  explicit Narrative(Audience audience) : Narrative(Verbosity::quiet) {
    audience_ = std::move(audience);
  }
  explicit Narrative(Verbosity verbosity = Verbosity::normal)
      : verbosity_(verbosity), noted_(std::make_shared<std::set<std::string>>()) {}

  /// "[map] 12 ms, 4512 points"
  void stage(const std::string& name, double ms, const std::string& what) const;
  /// Something to know that is no error; "note: …". Said once, however often it is noted.
  void note(const std::string& what) const;
  /// The same of one of many inputs: once for all that are alike in this way, with --verbose of
  /// each.
  void noteFirst(const std::string& way, const std::string& what) const;
  /// What all of it came to, in one line.
  void summary(const std::string& what) const;
  /// A line of a list.
  void line(const std::string& what) const;
  /// Only with --verbose.
  void detail(const std::string& what) const;
  bool isQuiet() const { return verbosity_ == Verbosity::quiet; }
  /// Wipes a bar, so that results can be printed where it stood.
  void clearBar() const;
  /// "error: …", also with --quiet, for one item of a batch whose rest goes on.
  void error(const std::string& what) const;
  /// A bar with rate and time left; empty if stderr is no terminal or the user wants quiet.
  Progress progress(const std::string& name) const;
  /// A bar for work that cannot be counted, which shows its seconds for as long as the result
  /// lives.
  Progress busy(const std::string& name) const;

 private:
  void say(const std::string& line, std::size_t indent) const;

  Verbosity verbosity_;
  Audience audience_;
  std::shared_ptr<std::set<std::string>> noted_;
};

/// Notes the stray points of the clouds that were read.
void logStrays(const FrameSource& source, const Narrative& narrate);

/// Notes which measurements of a recording were left out though nobody wished it, those of unknown
/// classes; throws Error if nothing is left of it.
void logLeftOut(const FrameSource& source, const LiftCounts& counts, const Narrative& narrate);

/// Says what became of the frames of a recording: a bar while they come, lines at the end.
class FrameReport {
 public:
  /// The recording must outlive it.
  FrameReport(const FrameSource& source, const Narrative& narrate);
  /// The same of a query: says how much of it is of classes that the map does not have.
  FrameReport(const FrameSource& source, const Narrative& narrate, LabelMatch in_map);
  void add(const PreprocessedFrame& frame);
  std::size_t added() const { return added_; }
  void say() const;

 private:
  const FrameSource& source_;
  const Narrative& narrate_;
  Progress progress_;
  std::size_t added_ = 0, points_ = 0, blobs_ = 0;
  LiftCounts left_out_;
  std::optional<LabelMatch> in_map_;
  std::map<std::uint32_t, std::size_t> alone_;  ///< points of classes without a partner there
};

/// The text without line breaks, so that every message is one line, and without what would steer a
/// terminal (printable); without its middle if it is very long.
std::string oneLine(const std::string& text);

}  // namespace xview::tools
