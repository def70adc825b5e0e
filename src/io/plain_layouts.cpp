// SPDX-License-Identifier: BSD-3-Clause
// Layouts of numbered files with camera.yaml and poses.txt: sequence folders, CARLA dumps, clouds.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "image_decoding.h"
#include "io/image_files.h"
#include "layouts.h"
#include "point_table.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

// ---- CARLA

constexpr double kEndOfDepth_m = 1000;  ///< of its depth camera
constexpr std::size_t kCarlaFramesToLookAt = 16;

/// Raw depth camera: 24 bits in red (lowest), green and blue, as a share of the farthest distance.
DepthImage readCodedDepth(const std::string& path, const Camera& camera) {
  const cv::Mat image = decodeImage(path, [&](std::int64_t width, std::int64_t height) {
    requireSameSize(path, width, height, "camera.yaml", camera.width, camera.height);
  });
  if (image.depth() != CV_8U || image.channels() < 3) {
    throw Error(path, "expected depth coded in 8-bit colours, found " + describePixels(image));
  }
  const int channels = image.channels();
  DepthImage depth(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* pixel = image.ptr<std::uint8_t>(y);  // blue, green, red
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      const int code = pixel[2] + 256 * pixel[1] + 65536 * pixel[0];
      // All ones is the sky.
      depth.at(x, y) = code == 0xFFFFFF ? 0 : static_cast<float>(kEndOfDepth_m * code / 0xFFFFFF);
    }
  }
  return depth;
}

/// The tags were renumbered in 0.9.14: road was 7 (now traffic light), and is 1 (was building).
LabelSet carlaLabels(const LabelCounts& counts) {
  const auto share_of = [&](std::uint32_t id) {
    const auto found = counts.find(id);
    return found == counts.end() ? 0 : found->second;
  };
  std::uint64_t all = 0, beyond_old = 0;
  for (const auto& [id, pixels] : counts) {
    all += pixels;
    if (id > 22) beyond_old += pixels;
  }
  const bool old_road = beyond_old == 0 && 50 * share_of(7) > all;
  return shippedLabelSet(old_road ? "carla" : "carla_0_9_14");
}

// ---- clouds

/// x, y, z and intensity as SemanticKITTI has them.
bool isScan(const std::string& path) { return fs::path(path).extension() == ".bin"; }

RecordingListing cloudListing(Sensor sensor, const InputOptions& options) {
  RecordingListing listing;
  listing.sensor = sensor;
  const CloudFields fields{options.label_field, options.instance_field};
  listing.read = [fields](const ListedFrame& listed, Frame& frame) {
    frame.cloud = isScan(listed.measurement) ? readKittiScan(listed.measurement, listed.label)
                                             : readCloud(listed.measurement, fields, false);
  };
  return listing;
}

/// Coordinates of single precision that are too large for centimetres; empty if they are not.
std::string coarseSteps(const std::string& path) {
  constexpr double kCoarse_m = 0.01;
  const float largest = largestFloatCoordinate(path);
  const double step_m = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
  if (step_m < kCoarse_m) return {};
  return fmt::format(
      "its coordinates are float32 and as large as {:.0f} m, so that they have steps of {} m; "
      "subtract "
      "an origin before they are made float32, or write them as doubles",
      largest, std::to_string(step_m).substr(0, 4));
}

/// Classes of LAS files have the numbers of the ASPRS. Where most points have none, or few are told
/// apart by them, the files are raw unless a label set was asked for.
void chooseLasClasses(RecordingListing& listing, const InputOptions& options,
                      const fs::path& folder) {
  constexpr double kFewest = 0.05, kMost = 0.5;  // shares of the points
  constexpr std::uint64_t kEnough = 10000000;    // points that are asked
  ClassifiedPoints asked;
  const auto isEnough = [](const ClassifiedPoints& points) {
    return points.hasTelling(kFewest) && points.hasClassified(kMost);
  };
  for (const ListedFrame& frame : listing.frames) {
    if (!options.labels.empty() || asked.all > kEnough) break;
    if (endingOf(frame.measurement) != ".las") continue;
    const bool is_only_one = listing.frames.size() == 1;
    const ClassifiedPoints here = classifiedPoints(
        frame.measurement, [&](const auto& points) { return is_only_one && isEnough(points); });
    asked.classified += here.classified;
    asked.telling += here.telling;
    asked.all += here.all;
  }
  if (options.labels.empty() && (asked.all == 0 || !isEnough(asked))) {
    const auto percentOf = [&](std::uint64_t part) {
      return 100 * static_cast<double>(part) / static_cast<double>(asked.all);
    };
    listing.notes.push_back(
        asked.telling == 0
            ? std::string("its points have no class but unclassified, ground or noise")
        : asked.hasTelling(kFewest)
            ? fmt::format("{:.0f} % of its points are unclassified; `--labels las` would take the "
                          "classes of the others",
                          percentOf(asked.all - asked.classified))
            : fmt::format(
                  "only {:.2g} % of its points have a class other than unclassified, ground "
                  "or noise, which `--labels las` would take",
                  percentOf(asked.telling)));
    return;
  }
  listing.labels =
      namedLabels(options, folder.string(), std::nullopt).value_or(shippedLabelSet("las"));
  if (options.labels.empty() && listing.labels.name() == "las")
    listing.notes.push_back(
        "its classes are those of the ASPRS (label set 'las'), as the LAS specification numbers "
        "them");
}

void noteRings(RecordingListing& listing) {
  if (hasRings(listing.frames.front().measurement))
    listing.notes.push_back(
        "its points have five numbers; the fifth, a whole one, is taken as the ring of the laser");
}

/// What the first cloud says of its classes holds for all; without a label field they are raw.
void chooseLabels(RecordingListing& listing, const InputOptions& options, const fs::path& folder) {
  if (isScan(listing.frames.front().measurement)) return noteRings(listing);
  const CloudFields fields{options.label_field, options.instance_field};
  const CloudHeader header = readCloudHeader(listing.frames.front().measurement, fields);
  listing.notes.insert(listing.notes.end(), header.notes.begin(), header.notes.end());
  const std::string coarse = coarseSteps(listing.frames.front().measurement);
  if (!coarse.empty()) listing.notes.push_back(coarse);
  if (header.label_field.empty()) return;
  if (header.format.rfind("LAS", 0) == 0 && header.label_field == "classification" &&
      !header.labels)
    return chooseLasClasses(listing, options, folder);
  if (header.label_field == "ObjTag" && !namedLabels(options, folder.string(), header.labels))
    listing.labels = carlaLabels(countLabels(listing, kCarlaFramesToLookAt));  // as CARLA writes
  else
    nameClasses(listing, options, folder.string(), header.labels);
}

// ---- SemanticKITTI

/// Tr of calib.txt: velodyne to camera 0.
Eigen::Isometry3d readVelodyneToCamera(const std::string& path) {
  InputFile file(path);
  std::vector<std::string_view> words;
  while (file.readWords(words)) {
    if (words[0] != "Tr:" && words[0] != "Tr") continue;
    words.erase(words.begin());
    const std::vector<double> numbers = file.numbersOf(words);
    if (numbers.size() != 12) {
      file.failAtLine("Tr: expected 12 numbers, found {}", numbers.size());
    }
    return poseFromRows(numbers.data(), file);
  }
  throw Error(path, "no line `Tr: ` with 12 numbers, velodyne to camera 0");
}

/// One time in seconds per line.
std::vector<double> readTimes(const std::string& path) {
  InputFile file(path);
  std::vector<double> times;
  std::vector<std::string_view> words;
  std::string_view line;
  while (file.readWords(words, "", &line)) {
    if (words.size() != 1) file.failAtLine("expected one number, found {}", inQuotes(line));
    times.push_back(file.numbersOf(words)[0]);
  }
  return times;
}

/// T_odom_velo = Tr^-1 T_cam Tr, so that the odometry frame is that of the velodyne where the poses
/// are identity. Without calib.txt poses are those of the velodyne, which the notes then say.
void setVelodynePoses(const fs::path& root, std::vector<ListedFrame>& frames,
                      std::vector<std::string>& notes) {
  const fs::path poses_path = root / "poses.txt";
  if (frames.size() == 1 && !fs::exists(poses_path)) return;
  setPoses(poses_path.string(), frames);
  const fs::path calibration = root / "calib.txt";
  Eigen::Isometry3d T_cam_velo = Eigen::Isometry3d::Identity();
  if (fs::exists(calibration))
    T_cam_velo = readVelodyneToCamera(calibration.string());
  else
    notes.push_back("no calib.txt: poses.txt is taken as poses of the scanner, not of a camera");
  for (ListedFrame& frame : frames) {
    frame.T_odom_sensor = T_cam_velo.inverse() * frame.T_odom_sensor * T_cam_velo;
  }
  const std::string times_path = (root / "times.txt").string();
  if (!fs::exists(times_path)) return;
  const std::vector<double> times = readTimes(times_path);
  const auto lines = linesOfFrames(times_path, "times", times.size(), numbersOf(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].stamp_s = times[lines[i]];
}

/// The labels of a single scan: beside it, or in the folder of a sequence; empty if it has none.
std::string labelFileOf(const fs::path& scan) {
  const fs::path beside = fs::path(scan).replace_extension(".label");
  if (fs::exists(beside)) return beside.string();
  const fs::path folder = fs::absolute(scan).parent_path().parent_path() / "labels";
  const fs::path in_sequence = folder / (scan.stem().string() + ".label");
  return fs::exists(in_sequence) ? in_sequence.string() : std::string();
}

/// classes.yaml may lie beside a single scan or in the folder of its sequence.
std::string folderOfClasses(const fs::path& path) {
  if (fs::is_directory(path)) return path.string();
  const fs::path folder = fs::absolute(path).parent_path();
  const bool in_sequence = folder.filename() == "velodyne" && !fs::exists(folder / "classes.yaml");
  return (in_sequence ? folder.parent_path() : folder).string();
}

}  // namespace

RecordingListing listSequence(const std::string& folder, const InputOptions& options) {
  const fs::path root(folder);
  const Camera camera = readCamera((root / "camera.yaml").string());
  const std::vector<std::string> kLabelEndings = {".png", ".tif", ".tiff"};
  RecordingListing listing;
  listing.frames =
      listFrames({"depth", (root / "depth").string(), {".png", ".tif", ".tiff", ".exr", ".pfm"}});
  const bool is_raw = !fs::exists(root / "label");
  if (!is_raw) {
    addFiles(folder, {"label", (root / "label").string(), kLabelEndings}, &ListedFrame::label,
             "depth", listing.frames);
  }
  if (fs::is_directory(root / "instance")) {
    addFiles(folder, {"instance", (root / "instance").string(), kLabelEndings},
             &ListedFrame::instance, "depth", listing.frames);
  }
  setPoses((root / "poses.txt").string(), listing.frames);
  listing.read = [camera](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readDepth(listed.measurement, camera);
    if (listed.label.empty()) return;
    frame.label = readLabels(listed.label, asLargeAsDepth(listed.label, listed, frame));
    if (listed.instance.empty()) return;
    frame.instance = readLabels(listed.instance, asLargeAsDepth(listed.instance, listed, frame));
  };
  if (!is_raw) nameClasses(listing, options, folder);
  return listing;
}

RecordingListing listCarla(const std::string& folder, const InputOptions& options) {
  const fs::path root(folder);
  const Camera camera = readCamera((root / "camera.yaml").string());
  RecordingListing listing;
  listing.frames = listFrames({"depth", (root / "depth").string(), {".png"}});
  addFiles(folder, {"semantic", (root / "semantic").string(), {".png"}}, &ListedFrame::label,
           "depth", listing.frames);
  setPoses((root / "poses.txt").string(), listing.frames);
  listing.read = [camera](const ListedFrame& listed, Frame& frame) {
    frame.camera = camera;
    frame.depth = readCodedDepth(listed.measurement, camera);
    const cv::Mat tags = decodeImage(listed.label, asLargeAsDepth(listed.label, listed, frame));
    frame.label = channelOf(tags, tags.channels() == 1 ? 0 : 2, listed.label);  // red: the tag
  };
  const auto named = namedLabels(options, folder);
  listing.labels = named ? *named : carlaLabels(countLabels(listing, kCarlaFramesToLookAt));
  return listing;
}

RecordingListing listCloud(const std::string& path, const InputOptions& options) {
  RecordingListing listing = cloudListing(Sensor::cloud, options);
  listing.frames.resize(1);
  listing.frames[0].measurement = path;
  chooseLabels(listing, options,
               fs::is_directory(path) ? fs::path(path) : fs::absolute(path).parent_path());
  return listing;
}

RecordingListing listCloudFolder(const std::string& folder, const InputOptions& options) {
  RecordingListing listing = cloudListing(Sensor::lidar, options);
  std::vector<std::string> endings = cloudEndings();
  endings.emplace_back(".bin");
  listing.frames = listFrames({"cloud", folder, endings});
  const fs::path poses = fs::path(folder) / "poses.txt";
  const bool has_poses = fs::exists(poses);
  if (listing.frames.size() > 1 && !has_poses) {
    throw Error(folder,
                fmt::format("{} clouds, but no poses.txt with a pose of each; give clouds of one "
                            "frame, or queries of their own, one by one: {}",
                            listing.frames.size(),
                            (fs::path(folder) / "*").string() +
                                fs::path(listing.frames[0].measurement).extension().string()));
  }
  if (has_poses) setPoses(poses.string(), listing.frames);
  chooseLabels(listing, options, folder);
  return listing;
}

RecordingListing listSemanticKitti(const std::string& path, const InputOptions& options) {
  RecordingListing listing;
  listing.sensor = Sensor::lidar;
  listing.read = [](const ListedFrame& listed, Frame& frame) {
    frame.cloud = readKittiScan(listed.measurement, listed.label);
  };
  if (fs::is_directory(path)) {
    const fs::path root(path);
    listing.frames = listFrames({".bin", (root / "velodyne").string(), {".bin"}});
    if (fs::exists(root / "labels")) {
      addFiles(path, {".label", (root / "labels").string(), {".label"}}, &ListedFrame::label,
               ".bin", listing.frames);
    }
    setVelodynePoses(root, listing.frames, listing.notes);
  } else {
    listing.frames.resize(1);
    listing.frames[0].number = frameNumberOf(path);
    listing.frames[0].measurement = path;
    listing.frames[0].label = labelFileOf(path);
  }
  noteRings(listing);
  if (listing.frames.front().label.empty()) return listing;  // raw
  if (const auto named = namedLabels(options, folderOfClasses(path)))
    listing.labels = *named;
  else
    guessSemanticKittiLabels(listing, options);
  return listing;
}

}  // namespace xview::io
