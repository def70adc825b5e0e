// SPDX-License-Identifier: BSD-3-Clause
#include "narrative.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "base/user_text.h"
#include "clock.h"
#include "process/library_chatter.h"
#include "terminal.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

void wipeLine() { printToUser("\r\x1b[K"); }

/// When a line was printed last, after which a bar waits a moment, so that it stands below.
std::atomic<Clock::time_point> g_said{Clock::time_point()};

/// Redrawn at most ten times a second, and twice a second while nothing is done; wiped when the
/// last item is done, or nobody counts on. A single item shows how long it has taken.
class Bar {
 public:
  explicit Bar(std::string name) : name_(std::move(name)), clock_([this] { tick(); }) {}
  Bar(const Bar&) = delete;
  Bar& operator=(const Bar&) = delete;
  ~Bar() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_over_ = true;
    }
    woken_.notify_one();
    clock_.join();
    wipeLine();
  }

  void show(std::size_t done, std::size_t total) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = done;
    total_ = total;
    if (done >= total) {
      wipeLine();
    } else if (done == 0 || secondsSince(drawn_) >= 0.1) {
      drawn_ = Clock::now();
      draw(done, total);
    }
  }

 private:
  void tick() {
    constexpr auto kEvery = std::chrono::milliseconds(500);
    constexpr double kBelow_s = 0.3;
    std::unique_lock<std::mutex> lock(mutex_);
    while (!woken_.wait_for(lock, kEvery, [this] { return is_over_; })) {
      if (done_ < total_ && secondsSince(g_said) >= kBelow_s) draw(done_, total_);
    }
  }

  void draw(std::size_t done, std::size_t total) const {
    const double spent_s = secondsSince(start_);
    if (total == 1) {
      if (spent_s >= 1) printToUser(fmt::format("\r[{}] {:.0f} s\x1b[K", name_, spent_s));
      return;
    }
    std::string numbers = fmt::format("{}/{}", done, total);
    if (done > 0) {
      const double rate = static_cast<double>(done) / std::max(spent_s, 1e-3);
      const double left_s = static_cast<double>(total - done) / std::max(rate, 1e-9);
      numbers += fmt::format("  {:.1f}/s  {:.0f} s left", rate, left_s);
    }
    const std::size_t text = columnsOf(name_) + numbers.size() + 5, room = textWidth(stderr);
    const std::size_t bar = std::min<std::size_t>(room > text ? room - text : 0, 30);
    const std::size_t filled = bar * done / total;
    printToUser(fmt::format("\r[{}] {}{} {}\x1b[K", name_, std::string(filled, '#'),
                            std::string(bar - filled, '.'), numbers));
  }

  std::string name_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point drawn_ = start_;
  std::size_t done_ = 0, total_ = 0;
  std::mutex mutex_;
  std::condition_variable woken_;
  bool is_over_ = false;
  std::thread clock_;
};

double percentOf(std::uint64_t count, const LiftCounts& counts) {
  return 100.0 * static_cast<double>(count) /
         static_cast<double>(std::max<std::uint64_t>(1, counts.all()));
}

std::string whyNothingIsLeft(const LiftCounts& counts, const std::string& unknown) {
  if (counts.ignored_class >= std::max(counts.no_depth, counts.out_of_range)) {
    return fmt::format(
        "{:.0f} % are unlabelled or of ignored classes{}; is it the right label set "
        "(--labels, --label-field)? `--labels shapes` leaves the labels aside",
        percentOf(counts.ignored_class, counts), unknown.empty() ? "" : ":" + unknown);
  }
  if (counts.out_of_range >= counts.no_depth) {
    return fmt::format(
        "{:.0f} % are nearer than lift.min_range_m or farther than "
        "lift.max_range_m; are they in millimetres?",
        percentOf(counts.out_of_range, counts));
  }
  return fmt::format("{:.0f} % have no depth", percentOf(counts.no_depth, counts));
}

/// The classes that a recording does not know, the most frequent first; of many the first few.
std::string unknownClasses(const FrameSource& source, const LiftCounts& counts) {
  constexpr std::size_t kListed = 4;
  const auto amount = [&](std::uint64_t count) {
    const double percent = percentOf(count, counts);
    return percent < 0.1 ? std::to_string(count)
                         : fmt::format("{:.{}f} %", percent, percent < 1 ? 1 : 0);
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (const auto& [label, count] : counts.unknown) order.emplace_back(count, label);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::string text;
  std::uint64_t others = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto [count, label] = order[i];
    if (i >= kListed && order.size() > kListed + 1)
      others += count;
    else
      text +=
          fmt::format("{} {} {}", i > 0 ? "," : "", amount(count), source.describeUnknown(label));
  }
  if (others == 0) return text;
  return text + fmt::format(" and {} other ids, {}", order.size() - kListed, amount(others));
}

}  // namespace

/// On a terminal long lines are broken between words.
void Narrative::say(const std::string& line, std::size_t indent) const {
  clearBar();
  const auto width = terminalWidth(stderr);
  printToUser((width ? wrapped(line, *width - indent, indent) : line) + "\n");
}

void Narrative::stage(const std::string& name, double ms, const std::string& what) const {
  if (verbosity_ != Verbosity::quiet)
    say(fmt::format("[{}] {:.0f} ms, {}", name, ms, printable(what)), 2);
}

void Narrative::note(const std::string& what) const {
  if ((verbosity_ == Verbosity::quiet && !audience_.note) || !noted_->insert(what).second) return;
  if (audience_.note) return audience_.note(oneLine(what));
  say(inked("note:", Ink::amber, stderr) + " " + oneLine(what), 6);
}

void Narrative::noteFirst(const std::string& way, const std::string& what) const {
  if (noted_->insert(way).second)
    note(what);
  else
    detail(what);
}

void Narrative::summary(const std::string& what) const {
  if (verbosity_ != Verbosity::quiet) say(inked(oneLine(what), Ink::bold, stderr), 0);
}

void Narrative::line(const std::string& what) const {
  if (verbosity_ != Verbosity::quiet) say("  " + printable(what), 4);
}

void Narrative::detail(const std::string& what) const {
  if (verbosity_ == Verbosity::verbose) say("  " + oneLine(what), 4);
}

void Narrative::clearBar() const {
  if (isatty(STDERR_FILENO) != 1) return;
  g_said = Clock::now();
  wipeLine();
}

void Narrative::error(const std::string& what) const {
  say(inked("error:", Ink::red, stderr) + " " + oneLine(what), 7);
}

Progress Narrative::progress(const std::string& name) const {
  if (audience_.progress) return audience_.progress;
  if (verbosity_ == Verbosity::quiet || !isatty(STDERR_FILENO)) return {};
  return [bar = std::make_shared<Bar>(name)](std::size_t done, std::size_t total) {
    bar->show(done, total);
  };
}

Progress Narrative::busy(const std::string& name) const {
  if (audience_.progress) return {};
  Progress bar = progress(name);
  if (bar) bar(0, 1);
  return bar;
}

void logStrays(const FrameSource& source, const Narrative& narrate) {
  if (const LeftOut left_out = source.leftOut(); left_out.any())
    narrate.note(source.name() + ": " + left_out.text());
}

void logLeftOut(const FrameSource& source, const LiftCounts& counts, const Narrative& narrate) {
  logStrays(source, narrate);
  const std::string classes = unknownClasses(source, counts);
  if (counts.all() == 0) throw Error(source.name(), "it is empty: it holds no finite point");
  if (counts.lifted == 0)
    throw Error(source.name(), fmt::format("none of its {} measurements is left: {}", counts.all(),
                                           whyNothingIsLeft(counts, classes)));
  if (!classes.empty())
    narrate.note(fmt::format("{}: of its measurements are left out as unlabelled:{}", source.name(),
                             classes));
  constexpr double kMost_percent = 50;
  const double ignored_percent = percentOf(counts.ignored_class, counts);
  if (source.sensor() != Sensor::camera && ignored_percent > kMost_percent)
    narrate.note(
        fmt::format("{}: {:.0f} % of its points are unlabelled or of ignored classes; "
                    "`--labels shapes` takes classes from shapes instead",
                    source.name(), ignored_percent));
}

FrameReport::FrameReport(const FrameSource& source, const Narrative& narrate)
    : source_(source), narrate_(narrate), progress_(narrate.progress("frames")) {}

FrameReport::FrameReport(const FrameSource& source, const Narrative& narrate, LabelMatch in_map)
    : FrameReport(source, narrate) {
  if (in_map.isHopeless() || knowsShapesOnly(in_map.from())) return;
  for (const std::uint32_t id : in_map.alone()) alone_[id] = 0;
  in_map_ = std::move(in_map);
}

void FrameReport::add(const PreprocessedFrame& frame) {
  ++added_;
  if (!alone_.empty()) {
    for (const Point& p : frame.cloud.points) {
      const auto alone = alone_.find(p.label);
      if (alone != alone_.end()) ++alone->second;
    }
  }
  points_ += frame.cloud.size();
  blobs_ += frame.blobs.size();
  left_out_ += frame.counts;
  if (progress_) progress_(added_, source_.size());
}

void FrameReport::say() const {
  narrate_.detail(
      fmt::format("{}: {} frames, {} points, {} blobs", source_.name(), added_, points_, blobs_));
  narrate_.detail(
      fmt::format("left out: {} measurements without depth, {} out of range, {} of ignored classes",
                  left_out_.no_depth, left_out_.out_of_range, left_out_.ignored_class));
  logLeftOut(source_, left_out_, narrate_);
  std::string text;
  for (const auto& [id, count] : alone_) {
    if (count == 0) continue;
    text +=
        fmt::format("{} {:.{}f} % {} (no counterpart in label set '{}')", text.empty() ? "" : ",",
                    100. * static_cast<double>(count) / static_cast<double>(points_), 1,
                    in_map_->from().className(id), in_map_->to().name());
  }
  if (!text.empty()) narrate_.note(source_.name() + ": points that count for nothing:" + text);
}

std::string oneLine(const std::string& text) {
  // More than a path and what is wrong with it; names in files may have any length.
  constexpr std::size_t kLongest = 2400, kEnd = 800;
  std::string line = printable(text.size() <= kLongest ? text
                                                       : text.substr(0, kLongest - kEnd) + " ... " +
                                                             text.substr(text.size() - kEnd));
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace xview::tools
