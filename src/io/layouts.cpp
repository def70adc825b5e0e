// SPDX-License-Identifier: BSD-3-Clause
#include "layouts.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>
#include <optional>

#include "base/stray_points.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/io/pose_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

class ListedRecording : public FrameSource {
 public:
  ListedRecording(std::string name, RecordingListing listing)
      : name_(std::move(name)), listing_(std::move(listing)) {}

  std::size_t size() const override { return listing_.frames.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return at(index).T_odom_sensor; }
  double stamp(std::size_t index) const override { return at(index).stamp_s; }
  std::int64_t number(std::size_t index) const override { return at(index).number; }
  Frame read(std::size_t index) const override {
    Frame frame = readListed(listing_, at(index));
    left_out_.set(index, frame.cloud.left_out);
    return frame;
  }
  Sensor sensor() const override { return listing_.sensor; }
  const LabelSet& labels() const override { return listing_.labels; }
  const std::string& name() const override { return name_; }
  std::vector<std::string> notes() const override { return listing_.notes; }
  LeftOut leftOut() const override { return left_out_.sum(); }

 private:
  const ListedFrame& at(std::size_t index) const { return listing_.frames.at(index); }

  std::string name_;
  RecordingListing listing_;
  mutable LeftOutOfFrames left_out_;
};

// ---- files of frames

using StemAndPath = std::pair<std::string, std::string>;

/// Digits at the end of a stem. Not those behind a dot: "1305031102.175304" is a time, not frame
/// 175304.
std::optional<std::int64_t> trailingNumber(const std::string& stem) {
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  const std::size_t begin = last_other == std::string::npos ? 0 : last_other + 1;
  if (begin > 0 && stem[begin - 1] == '.') return std::nullopt;
  return numberFrom<std::int64_t>(std::string_view(stem).substr(begin));
}

/// The files of the series by name.
std::vector<StemAndPath> listFiles(const FileSeries& series) {
  std::error_code failed;
  fs::directory_iterator entries(series.folder, failed);
  if (failed) throw Error(series.folder, "cannot list the folder: " + failed.message());
  const std::vector<std::string>& endings = series.endings;
  std::vector<StemAndPath> files;
  for (const auto& entry : entries) {
    const fs::path& path = entry.path();
    if (std::find(endings.begin(), endings.end(), path.extension().string()) == endings.end())
      continue;
    if (path.filename().string()[0] == '.' || entry.is_directory(failed)) continue;
    files.push_back({path.stem().string(), path.string()});
  }
  if (files.empty()) {
    std::string expected;
    for (const std::string& ending : endings) expected += (expected.empty() ? "" : ", ") + ending;
    throw Error(series.folder, "no " + expected + " files");
  }
  std::sort(files.begin(), files.end());
  const auto twice = std::adjacent_find(
      files.begin(), files.end(),
      [](const StemAndPath& a, const StemAndPath& b) { return a.first == b.first; });
  if (twice != files.end()) {
    throw Error(twice->second,
                "there is also " + std::next(twice)->second + "; which is the frame?");
  }
  return files;
}

/// Those that have one.
std::map<std::int64_t, std::string> byNumber(const std::vector<StemAndPath>& files) {
  std::map<std::int64_t, std::string> numbered;
  for (const auto& [stem, path] : files) {
    if (const auto number = trailingNumber(stem)) numbered[*number] = path;
  }
  return numbered;
}

/// Gives frames other lengths and another odometry frame. A cloud without a pose is moved itself,
/// so that it is the one that its file would hold.
void moveFrames(const Eigen::Affine3d& moved, RecordingListing& listing) {
  constexpr double kExact = 1e-9;  // off by less are the digits of a rotation
  const double scale = std::cbrt(moved.linear().determinant());
  for (ListedFrame& frame : listing.frames) {
    Eigen::Isometry3d& T = frame.T_odom_sensor;
    if (listing.sensor == Sensor::cloud && T.matrix() == Eigen::Matrix4d::Identity()) continue;
    frame.T_before = T;
    T.linear() = moved.linear() / scale * T.linear();
    T.translation() = moved * T.translation();
  }
  listing.read = [moved, scale, read = std::move(listing.read)](const ListedFrame& listed,
                                                                Frame& frame) {
    if (!listed.T_before) {
      read(listed, frame);
      return moveCloud(moved, frame.cloud);
    }
    ListedFrame as_it_was = listed;
    as_it_was.T_odom_sensor = frame.T_odom_sensor = *listed.T_before;
    read(as_it_was, frame);
    if (std::abs(scale - 1) > kExact) scaleLengths(scale, frame);
    frame.T_odom_sensor = listed.T_odom_sensor;
  };
}

std::string stemOf(const ListedFrame& frame) { return fs::path(frame.measurement).stem().string(); }

}  // namespace

Frame readListed(const RecordingListing& listing, const ListedFrame& listed) {
  Frame frame;
  frame.number = listed.number;
  frame.stamp_s = listed.stamp_s;
  frame.sensor = listing.sensor;
  frame.T_odom_sensor = listed.T_odom_sensor;
  try {
    listing.read(listed, frame);
  } catch (const std::bad_alloc&) {
    throw Error(listed.measurement, "frame needs more memory than there is");
  }
  return frame;
}

std::unique_ptr<FrameSource> makeRecording(const std::string& name, RecordingListing listing) {
  return std::make_unique<ListedRecording>(name, std::move(listing));
}

std::unique_ptr<FrameSource> makeRecording(const std::string& path, RecordingListing listing,
                                           const FrameRange& range,
                                           const std::optional<Eigen::Affine3d>& moved) {
  const std::size_t count = listing.frames.size();
  const std::size_t end = std::min(range.end.value_or(count), count);
  if (range.begin >= end) {
    throw UsageError(fmt::format("--frames {}:{} has no frames: {} has {}", range.begin,
                                 range.end ? std::to_string(*range.end) : "", path, count));
  }
  std::vector<ListedFrame> chosen;
  for (std::size_t i = range.begin; i < end; i += std::min(range.step, end - i)) {
    chosen.push_back(std::move(listing.frames[i]));
  }
  listing.frames = std::move(chosen);
  for (const ListedFrame& frame : listing.frames) {
    const double away_m = frame.T_odom_sensor.translation().cwiseAbs().maxCoeff();
    if (!(away_m <= kFarthest_m))
      throw Error(path, fmt::format("frame {} has a pose {:.3g} m from the origin, expected {:.0e} "
                                    "m at most",
                                    frame.number, away_m, kFarthest_m));
  }
  if (moved) moveFrames(*moved, listing);
  return makeRecording(path, std::move(listing));
}

std::vector<ListedFrame> listFrames(const FileSeries& measurements) {
  const std::vector<StemAndPath> files = listFiles(measurements);
  const std::map<std::int64_t, std::string> numbered = byNumber(files);
  std::vector<ListedFrame> frames(files.size());
  // Numbers count if every file has one of its own.
  const bool all = numbered.size() == files.size();
  auto next = numbered.begin();
  for (std::size_t i = 0; i < files.size(); ++i) {
    frames[i].number = all ? next->first : static_cast<std::int64_t>(i);
    frames[i].measurement = all ? (next++)->second : files[i].second;
  }
  return frames;
}

void addFiles(const std::string& recording, const FileSeries& series,
              std::string ListedFrame::*file, const std::string& measurements_name,
              std::vector<ListedFrame>& frames) {
  const std::vector<StemAndPath> files = listFiles(series);
  std::map<std::string, std::string> paths(files.begin(), files.end());  // by stem
  const std::string counts = fmt::format("{} {} files but {} {} files; ", frames.size(),
                                         measurements_name, files.size(), series.name);
  for (ListedFrame& frame : frames) {
    const auto found = paths.find(stemOf(frame));
    if (found == paths.end())
      throw Error(recording, counts + stemOf(frame) + " has no " + series.name + " file");
    frame.*file = found->second;
    paths.erase(found);
  }
  if (paths.empty()) return;
  throw Error(recording, counts + paths.begin()->first + " has no " + measurements_name + " file");
}

std::vector<std::string> colorFiles(const FrameSource& recording) {
  constexpr double kSameTime_s = 0.05;
  const fs::path root(recording.name()), folder = root / "rgb", list = root / "rgb.txt";
  const bool is_listed = fs::exists(list) && fs::exists(root / "depth.txt");
  if (!is_listed && !fs::is_directory(folder))
    throw Error(folder, "no such folder; a network labels the images of RECORDING/rgb");
  std::vector<StampedFile> stamped;
  std::map<std::int64_t, std::string> numbered;
  if (is_listed)
    stamped = readFileList(list);
  else
    numbered = byNumber(listFiles({"rgb", folder, {".png", ".jpg", ".jpeg"}}));
  std::vector<std::string> colors;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const std::int64_t number = recording.number(i);
    const double stamp_s = recording.stamp(i);
    const StampedFile* nearest = nearestTo(stamp_s, stamped, kSameTime_s);
    if (is_listed && !nearest)
      throw Error(list, fmt::format("no image within {} s of frame {}, which is of {:.3f} s",
                                    kSameTime_s, number, stamp_s));
    if (!is_listed && numbered.count(number) == 0)
      throw Error(folder, fmt::format("no image of frame {}", number));
    colors.push_back(is_listed ? nearest->path : numbered[number]);
  }
  return colors;
}

std::int64_t frameNumberOf(const std::string& path) {
  return trailingNumber(fs::path(path).stem().string()).value_or(0);
}

std::vector<std::int64_t> numbersOf(const std::vector<ListedFrame>& frames) {
  std::vector<std::int64_t> numbers;
  for (const ListedFrame& frame : frames) numbers.push_back(frame.number);
  return numbers;
}

std::vector<std::size_t> linesOfFrames(const std::string& path, const std::string& what,
                                       std::size_t lines,
                                       const std::vector<std::int64_t>& numbers) {
  const std::string counts = fmt::format("{} {} for {} frames", lines, what, numbers.size());
  if (lines < numbers.size()) throw Error(path, counts);
  std::vector<std::size_t> chosen(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::int64_t line = lines == numbers.size() ? static_cast<std::int64_t>(i) : numbers[i];
    if (line < 0 || static_cast<std::uint64_t>(line) >= lines) {
      throw Error(path, fmt::format("{}, taken by the number of the frame, but frame {} is beyond "
                                    "the last line",
                                    counts, line));
    }
    chosen[i] = static_cast<std::size_t>(line);
  }
  return chosen;
}

void setPoses(const std::string& path, std::vector<ListedFrame>& frames) {
  const std::vector<StampedPose> poses = posesOfFrames(path, numbersOf(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].stamp_s = poses[i].stamp_s;
    frames[i].T_odom_sensor = poses[i].T_frame_sensor;
  }
}

void requireSameSize(const std::string& path, std::int64_t width, std::int64_t height,
                     const std::string& other_path, int other_width, int other_height) {
  if (width == other_width && height == other_height) return;
  throw Error(path, fmt::format("{} x {} pixels, but {} has {} x {}", width, height, other_path,
                                other_width, other_height));
}

std::function<void(std::int64_t, std::int64_t)> asLargeAsDepth(const std::string& path,
                                                               const ListedFrame& listed,
                                                               const Frame& frame) {
  return [&](std::int64_t width, std::int64_t height) {
    requireSameSize(path, width, height, listed.measurement, frame.depth.width, frame.depth.height);
  };
}

}  // namespace xview::io
