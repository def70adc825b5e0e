// SPDX-License-Identifier: BSD-3-Clause
#include "arriving_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <thread>

#include "base/user_text.h"
#include "outputs.h"
#include "pose_text.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBlanks = " \t\r";
/// A path has 4096 bytes at most, and a pose far less.
constexpr std::size_t kLongestLine = 8192;

/// A cloud is complete if it has not changed for so long [s].
constexpr double kSettled_s = 0.25;
/// So long it may be empty or shorter than its header says, and others wait for it [s].
constexpr double kPatience_s = 2;
/// So long its line of poses.txt, which may be written in large blocks, is waited for [s].
constexpr double kPatienceForPose_s = 60;
/// Files that are looked at in one go: the first by name.
constexpr std::size_t kMostLookedAt = 64;

struct Line {
  std::string text;  ///< its first kLongestLine bytes
  bool is_cut = false;
  bool has_end = false;  ///< a line break follows
};

std::optional<Line> nextLine(std::FILE* file) {
  Line line;
  int c = 0;
  while ((c = getc_unlocked(file)) != EOF && c != '\n') {
    if (line.text.size() < kLongestLine)
      line.text += static_cast<char>(c);
    else
      line.is_cut = true;
  }
  line.has_end = c == '\n';
  if (!line.has_end && line.text.empty()) return std::nullopt;
  return line;
}

bool saysSomething(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(kBlanks);
  return begin != std::string::npos && line[begin] != '#';
}

std::string shortened(const std::string& text) {
  constexpr std::size_t kLongest = 80;
  return text.size() > kLongest ? text.substr(0, kLongest) + "..." : text;
}

std::string noPose(const std::string& text) {
  return fmt::format("expected {}, found '{}'", kStampedPose, shortened(text));
}

void setPose(const io::StampedPose& pose, ArrivedFile& file) {
  file.stamp_s = pose.stamp_s;
  file.T_odom_sensor = pose.T_frame_sensor;
}

/// The end of what stands before the last words of a text; npos if nothing does.
std::size_t endBefore(const std::string& text, std::size_t end) {
  const std::size_t blank = text.find_last_of(kBlanks, end);
  return blank == std::string::npos ? blank : text.find_last_not_of(kBlanks, blank);
}

/// If the text is no file, but its beginning is one, the words behind that were meant as a pose.
void splitWrongPose(ArrivedFile& file) {
  constexpr int kMostWords = 16;
  std::error_code failed;
  if (fs::exists(file.path, failed)) return;
  std::size_t end = file.path.size() - 1;
  for (int words = 0; words < kMostWords; ++words) {
    end = endBefore(file.path, end);
    if (end == std::string::npos) return;
    const std::string path = file.path.substr(0, end + 1);
    if (!fs::exists(path, failed)) continue;
    const std::string rest = file.path.substr(file.path.find_first_not_of(kBlanks, end + 1));
    file.error = path + ": its pose: " + noPose(rest);
    file.path = path;
    return;
  }
}

ArrivedFile fileFrom(const std::string& line) {
  constexpr int kNumbersOfPose = 8;
  ArrivedFile file;
  const std::size_t begin = line.find_first_not_of(kBlanks);
  const std::size_t last = line.find_last_not_of(kBlanks);
  std::size_t end = last;
  for (int i = 0; i < kNumbersOfPose && end != std::string::npos; ++i) end = endBefore(line, end);
  if (end != std::string::npos && end > begin) {
    if (const auto pose = parseStampedPose(line.substr(end + 1))) {
      setPose(*pose, file);
      file.path = line.substr(begin, end + 1 - begin);
      return file;
    }
  }
  file.path = line.substr(begin, last + 1 - begin);
  splitWrongPose(file);
  return file;
}

/// The digits at the end of a name without its ending: 12 of "scan_000012.pcd".
std::optional<std::uint64_t> numberOf(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const std::size_t before = stem.find_last_not_of("0123456789");
  return numberFrom<std::uint64_t>(stem.substr(before == std::string::npos ? 0 : before + 1));
}

/// False if the file is shorter than what it holds should be. Text does not tell.
bool isWhole(const std::string& path, std::uintmax_t bytes) {
  constexpr std::uintmax_t kBytesOfPoint = 16;  // of a KITTI scan, which has no header
  if (!io::isCloudFile(path)) return bytes % kBytesOfPoint == 0;
  try {
    io::readCloudHeader(path);
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// What poses.txt says of a frame.
struct PoseLine {
  std::optional<std::string> text;  ///< nothing if it has no such line yet
  std::uint64_t lines = 0;          ///< that it has
};

/// A line without its end is still being written.
PoseLine lineOf(const std::string& path, std::uint64_t number) {
  std::error_code failed;
  if (!fs::is_regular_file(path, failed)) throw Error(path, "is not a regular file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "re"),
                                                             &std::fclose);
  if (!file) throw Error(path, std::string("cannot open: ") + std::strerror(errno));
  PoseLine found;
  while (const auto line = nextLine(file.get())) {
    if (!line->has_end) break;
    if (!saysSomething(line->text)) continue;
    if (found.lines++ != number) continue;
    found.text = line->text;
    break;
  }
  return found;
}

}  // namespace

std::optional<ArrivedFile> nextNamed(std::FILE* lines) {
  while (const auto line = nextLine(lines)) {
    if (line->is_cut) {
      ArrivedFile file{shortened(line->text)};
      file.error = fmt::format("standard input: a line of more than {} bytes, expected PATH [{}]",
                               kLongestLine, "stamp tx ty tz qx qy qz qw");
      return file;
    }
    if (saysSomething(line->text)) return fileFrom(line->text);
  }
  return std::nullopt;
}

std::optional<ArrivedFile> FillingFolder::next() {
  constexpr auto kPoll = std::chrono::milliseconds(20);
  sign_of_life_ = Clock::now();
  while (true) {
    std::error_code failed;
    const bool is_ended = !stop_.empty() && fs::exists(stop_, failed);
    list();
    is_over_ =
        is_over_ || (idle_s_ > 0 && secondsSince(sign_of_life_) > std::max(idle_s_, kSettled_s));
    const Wait wait = is_ended ? Wait::is_ended : is_over_ ? Wait::is_over : Wait::on;
    if (auto file = firstReady(wait)) {
      taken_.insert(fs::path(file->path).filename().string());
      return file;
    }
    if (wait != Wait::on) return std::nullopt;
    std::this_thread::sleep_for(kPoll);
  }
}

std::string FillingFolder::pathOf(const std::string& name) const {
  return (fs::path(folder_) / name).string();
}

void FillingFolder::list() {
  std::error_code failed;
  std::map<std::string, Pending> there;
  for (fs::directory_iterator entry(folder_, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    const bool is_cloud = io::isCloudFile(name) || endingOf(name) == ".bin";
    if (!is_cloud || name[0] == '.' || taken_.count(name) != 0) continue;
    const auto known = pending_.find(name);
    if (known == pending_.end())
      there.emplace(name, Pending());
    else
      there.insert(pending_.extract(known));
  }
  pending_ = std::move(there);
  std::size_t looked_at = 0;
  for (auto& [name, file] : pending_) {
    if (++looked_at > kMostLookedAt) break;
    look(name, file);
  }
}

void FillingFolder::look(const std::string& name, Pending& file) {
  const std::string path = pathOf(name);
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  file.problem = fs::is_regular_file(status) ? ""
                 : fs::is_directory(status)  ? "is a folder, expected a file"
                 : fs::exists(status)        ? "is not a regular file"
                                             : "is a link to nothing";
  Mark mark;
  if (file.problem.empty()) {
    mark.bytes = fs::file_size(path, failed);
    if (!failed) mark.time = fs::last_write_time(path, failed);
    if (failed) mark = {};
  }
  if (mark == file.mark) return;
  file.mark = mark;
  file.is_whole.reset();
  file.changed = Clock::now();
  if (secondsSince(file.seen) < kPatience_s) sign_of_life_ = file.changed;
}

std::optional<ArrivedFile> FillingFolder::firstReady(Wait wait) {
  std::size_t looked_at = 0;
  for (auto& [name, file] : pending_) {
    if (++looked_at > kMostLookedAt) break;
    if (auto arrived = ready(name, file, wait)) return arrived;
    if (wait == Wait::on && secondsSince(file.seen) < kPatience_s) return std::nullopt;
  }
  return std::nullopt;
}

/// Nothing if it is waited for.
std::optional<ArrivedFile> FillingFolder::ready(const std::string& name, Pending& file,
                                                Wait wait) const {
  const std::string path = pathOf(name);
  const auto failure = [&](const char* what) {
    ArrivedFile failed{path};
    failed.error = path + ": " + what;
    return failed;
  };
  const double unchanged_s = secondsSince(file.changed);
  if (unchanged_s < kSettled_s && wait == Wait::on) return std::nullopt;
  if (!file.problem.empty()) return failure(file.problem.c_str());
  if (unchanged_s < kSettled_s && wait == Wait::is_over) return failure("is still being written");
  if (!file.is_whole) file.is_whole = file.mark.bytes > 0 && isWhole(path, file.mark.bytes);
  if (!*file.is_whole) {
    if (unchanged_s < kPatience_s && wait == Wait::on) return std::nullopt;
    if (file.mark.bytes == 0) return failure("is empty");
    return ArrivedFile{path};  // its reader says what is missing
  }
  return withPose(name, file, wait);
}

std::optional<ArrivedFile> FillingFolder::withPose(const std::string& name, Pending& file,
                                                   Wait wait) const {
  ArrivedFile arrived{pathOf(name)};
  const std::string poses = pathOf("poses.txt");
  std::error_code failed;
  if (!fs::exists(fs::symlink_status(poses, failed))) return arrived;
  const auto number = numberOf(name);
  if (!number) {
    arrived.error = arrived.path + ": its name has no number, so it has no line in " + poses;
    return arrived;
  }
  try {
    const Mark now{fs::file_size(poses, failed), fs::last_write_time(poses, failed)};
    const bool is_last = wait != Wait::on || secondsSince(file.changed) > kPatienceForPose_s;
    if (file.poses_then == now && !is_last) return std::nullopt;
    const PoseLine line = lineOf(poses, *number);
    if (!line.text && !is_last) {
      file.poses_then = now;
      return std::nullopt;
    }
    if (!line.text)
      throw Error(poses, fmt::format("no line of number {} for {}, it has {}; the first is 0",
                                     *number, name, line.lines));
    const auto pose = parseStampedPose(*line.text);
    if (!pose) throw Error(fmt::format("{}: line of frame {}", poses, *number), noPose(*line.text));
    setPose(*pose, arrived);
  } catch (const Error& e) {
    arrived.error = e.what();
  }
  return arrived;
}

}  // namespace xview::tools
