// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "base/parallel.h"
#include "base/user_text.h"
#include "cloud_tiles.h"
#include "input_file.h"
#include "io/bag_files.h"
#include "io/image_files.h"
#include "layouts.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

// ---- what a path is

/// A kind of input by its number: its name, and who lists its frames; null if it has none.
struct Kind {
  const char* name;
  RecordingListing (*list)(const std::string& path, const InputOptions& options);
};
constexpr Kind kKinds[] = {{"sequence", listSequence}, {"semantic_kitti", listSemanticKitti},
                           {"cloud", listCloud},       {"cloud_folder", listCloudFolder},
                           {"graph", nullptr},         {"map", nullptr},
                           {"synthia", listSynthia},   {"airsim", listAirsim},
                           {"tum_rgbd", listTumRgbd},  {"virtual_kitti", listVirtualKitti},
                           {"carla", listCarla},       {"bag", listBag}};

InputKind requireKind(const std::string& name) {
  if (const auto kind = enumeratorNamed(name, InputKind::bag)) return *kind;
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  throw UsageError("--input-kind " + name + ": unknown" + knownWordsHint(name, names));
}

[[noreturn]] void failBetween(const std::string& path, InputKind a, InputKind b,
                              const std::string& why) {
  throw Error(path, std::string("may be a ") + toString(a) + " or a " + toString(b) + " (" + why +
                        "); say which with --input-kind");
}

bool hasClouds(const fs::path& folder) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    if (isCloudFile(entry.path().string()) || entry.path().extension() == ".bin") return true;
  }
  return false;
}

// ---- what is not read, and the way from there

/// Kinds of files that are not read, and commands that make one of them that is. {0} is the file,
/// {1} the same without its ending.
struct Conversion {
  const char* endings;  ///< each with a blank before and behind
  const char* text;
};
constexpr Conversion kConversions[] = {
    {" .laz .copc ",
     "compressed LAS is not read; unpack it: pdal translate {0} {1}.las, or laszip -i {0} -o "
     "{1}.las"},
    {" .ptx .pts ",
     "this scanner format is not read; convert it: pdal translate {0} {1}.las or "
     "CloudCompare -O -GLOBAL_SHIFT AUTO {0} -C_EXPORT_FMT LAS -SAVE_CLOUDS"},
    {" .pcap .pcapng ",
     "packets of a scanner are not read; record its driver's topic of PointCloud2 in a bag: ros2 "
     "bag record /points"},
    {" .fls .rcp .rcs .zfs .ptg ",
     "a format of one maker's scanners is not read; export E57, LAS or PLY from its program"},
    {" .xyz .csv .txt .asc .xyzrgb .neu .dat ",
     "points as text are not read; convert them: CloudCompare -O -GLOBAL_SHIFT AUTO {0} "
     "-C_EXPORT_FMT LAS -SAVE_CLOUDS"},
    {" .obj .stl .off .gltf .glb .fbx .dae .3ds .ifc .dxf ",
     "meshes are not read; sample points on its surface: CloudCompare -O {0} -SAMPLE_MESH DENSITY "
     "100 -C_EXPORT_FMT PLY -SAVE_CLOUDS"},
    {" .npy .npz ",
     "arrays of NumPy are not read; N x 4 of float32 (x y z intensity) become a scan: "
     "array.astype('f4').tofile('{1}.bin')"},
    {" .gz ", "is compressed; unpack it: gunzip -k {0}"},
    {" .bz2 ", "is compressed; unpack it: bunzip2 -k {0}"},
    {" .xz ", "is compressed; unpack it: unxz -k {0}"},
    {" .zst .zstd ", "is compressed; unpack it: unzstd {0}"},
    {" .lz4 ", "is compressed; unpack it: unlz4 {0}"},
    {" .zip ", "is an archive; unpack it: unzip {0} -d {1}"},
    {" .7z .rar ", "is an archive; unpack it: 7z x {0} -o{1}"},
    {" .tar .tgz .tbz2 .txz ", "is an archive; unpack it: tar xf {0}"},
    {" .png .jpg .jpeg .tif .tiff .exr .pfm ",
     "is one image; a recording is a folder with camera.yaml, depth/ and poses.txt"},
    {" .mp4 .avi .mkv .mov ",
     "a film has no depth; give depth images with camera.yaml and poses.txt, or a cloud"},
    {" .yaml .yml .json .jsonl ",
     "is a text, not a recording; give the folder, cloud or map that it belongs to"},
};

/// What to do with a file of such an ending; empty if nobody knows.
std::string wayTo(const std::string& ending, const std::string& path) {
  if (ending.empty()) return {};
  for (const Conversion& known : kConversions) {
    if (std::string(known.endings).find(" " + ending + " ") == std::string::npos) continue;
    const std::string stem = fs::path(path).replace_extension().string();
    return fmt::format(fmt::runtime(known.text), path, stem);
  }
  return {};
}

/// The same for the first file in a folder, by name, that is known; begins with "; ".
std::string wayOutOf(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const std::string ending = endingOf(file.string()), way = wayTo(ending, file.string());
    const bool beside = ending == ".png" || ending == ".yaml" || ending == ".json";
    if (!way.empty() && !beside) return "; of " + file.string() + ": " + way;
  }
  return {};
}

InputKind recogniseFolder(const fs::path& folder) {
  const auto has = [&](const char* name) { return fs::exists(folder / name); };
  std::vector<InputKind> kinds;
  if (has("camera.yaml") && has("semantic")) {
    kinds.push_back(InputKind::carla);
  } else if (has("airsim_rec.txt")) {
    kinds.push_back(InputKind::airsim);
  } else if (has("depth.txt") && has("groundtruth.txt")) {
    kinds.push_back(InputKind::tum_rgbd);
  } else if (has("camera.yaml") || (has("depth") && has("label"))) {
    kinds.push_back(InputKind::sequence);
  }
  if (has("velodyne")) kinds.push_back(InputKind::semantic_kitti);
  if (has("GT/LABELS") || isSynthiaCamera(folder.string())) kinds.push_back(InputKind::synthia);
  if (has("extrinsic.txt") && has("frames")) kinds.push_back(InputKind::virtual_kitti);
  if (kinds.empty() && has("metadata.yaml") && isBag(folder.string()))
    kinds.push_back(InputKind::bag);
  if (kinds.empty() && isTiledCloud(folder.string())) kinds.push_back(InputKind::cloud);
  if (kinds.empty() && hasClouds(folder)) kinds.push_back(InputKind::cloud_folder);
  if (kinds.empty() && isBag(folder.string())) kinds.push_back(InputKind::bag);
  if (kinds.size() > 1)
    failBetween(folder.string(), kinds[0], kinds[1], "it has the folders of both");
  if (kinds.empty()) {
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed)) {
      const std::string ending = endingOf(entry.path().string()),
                        of_part = endingOf(entry.path().stem().string());
      if ((ending == ".zstd" || ending == ".zst") && (of_part == ".mcap" || of_part == ".db3"))
        throw Error(folder.string(),
                    fmt::format("a rosbag2 whose parts are compressed; unpack them: unzstd {}/*{}",
                                folder.string(), ending));
    }
    throw Error(folder.string(),
                "not a recording: expected camera.yaml with depth/, velodyne/, .pcd, .ply, .las, "
                ".e57 or .bin files, a rosbag2, or the layout of a known data set" +
                    wayOutOf(folder));
  }
  return kinds[0];
}

InputKind recogniseFile(const std::string& path, const InputOptions& options, std::string* guess) {
  const std::string ending = endingOf(path);
  if (ending == ".xvm") return InputKind::map;
  if (ending == ".bin") return InputKind::semantic_kitti;
  if (ending == ".ply")
    return holdsGraph(path, options, guess) ? InputKind::graph : InputKind::cloud;
  if (isCloudFile(path)) return InputKind::cloud;
  if (isBag(path)) return InputKind::bag;
  if (const std::string way = wayTo(ending, path); !way.empty()) throw Error(path, way);
  throw Error(
      path,
      "not a known kind of file: expected .xvm, .ply, .pcd, .las, .e57, .bin, .mcap, .db3, .bag "
      "or a folder");
}

// ---- writing

std::string numbered(const std::string& folder, std::int64_t number, const char* ending) {
  return fmt::format("{}/{:06d}.{}", folder, number, ending);
}

std::string classesYaml(const LabelSet& labels) {
  std::string text =
      labels.name().empty() ? "" : fmt::format("name: {}\n", yamlQuoted(labels.name()));
  text += "classes:\n";
  for (const auto& [id, info] : labels.classes()) {
    text += fmt::format("  - {{id: {}, name: {}, color: [{}, {}, {}], role: {}, kind: {}}}\n", id,
                        yamlQuoted(info.name), info.color[0], info.color[1], info.color[2],
                        toString(info.role), toString(info.kind));
  }
  return text;
}

void writeCameraFrame(const std::string& folder, const Frame& frame) {
  writeDepthPng(numbered(folder + "/depth", frame.number, "png"), frame.depth,
                frame.camera.depth_scale);
  writeLabelPng(numbered(folder + "/label", frame.number, "png"), frame.label);
  if (!frame.instance.empty()) {
    writeLabelPng(numbered(folder + "/instance", frame.number, "png"), frame.instance);
  }
}

void writeScan(const std::string& folder, const Frame& frame) {
  const LabelledCloud& cloud = frame.cloud;
  std::vector<float> points;
  std::vector<std::uint32_t> labels;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i).cast<float>();
    points.insert(points.end(), {p.x(), p.y(), p.z(), 0.0f});  // the simulator knows no intensity
    const std::uint32_t instance = cloud.points[i].instance & 0xFFFFu;
    labels.push_back((cloud.points[i].label & 0xFFFFu) | instance << 16);
  }
  writeFile(numbered(folder + "/velodyne", frame.number, "bin"), points);
  writeFile(numbered(folder + "/labels", frame.number, "label"), labels);
}

/// KITTI poses are those of a camera; a calibration of identity says that camera and scanner are
/// one.
void writeKittiPoses(const std::string& folder, const FrameSource& source) {
  std::string poses, times;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Matrix4d T = source.pose(i).matrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) poses += fmt::format("{} ", T(row, column));
    }
    poses.back() = '\n';
    times += fmt::format("{}\n", source.stamp(i));
  }
  writeFile(folder + "/poses.txt", poses);
  writeFile(folder + "/times.txt", times);
  writeFile(folder + "/calib.txt", std::string("Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n"));
}

std::vector<StampedPose> stamped(const FrameSource& source,
                                 const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<StampedPose> result;
  for (std::size_t i = 0; i < poses.size(); ++i) result.push_back({source.stamp(i), poses[i]});
  return result;
}

void writeSidecars(const std::string& folder, const FrameSource& source) {
  writeFile(folder + "/classes.yaml", classesYaml(source.labels()));
  if (source.sensor() != Sensor::camera) return writeKittiPoses(folder, source);
  writeCamera(folder + "/camera.yaml", source.read(0).camera);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < source.size(); ++i) poses.push_back(source.pose(i));
  writeTumPoses(folder + "/poses.txt", stamped(source, poses));
}

void writeParts(const std::string& folder, const FrameSource& source,
                const std::vector<Eigen::Isometry3d>& truth, int threads,
                const std::function<void(std::size_t, std::size_t)>& progress) {
  const bool camera = source.sensor() == Sensor::camera;
  using Parts = std::vector<std::string>;
  for (const std::string& part :
       camera ? Parts{"depth", "label", "instance"} : Parts{"velodyne", "labels"}) {
    if (part == "instance" && source.read(0).instance.empty()) continue;
    makeFolder(folder + "/" + part);
  }
  writeSidecars(folder, source);
  if (!truth.empty()) writeTumPoses(folder + "/groundtruth.txt", stamped(source, truth));
  std::atomic<std::size_t> done{0};
  parallelFor(source.size(), threads, [&](std::size_t i) {
    const Frame frame = source.read(i);
    if (camera)
      writeCameraFrame(folder, frame);
    else
      writeScan(folder, frame);
    const std::size_t now = ++done;
    if (progress) progress(now, source.size());
  });
}

}  // namespace

const char* toString(InputKind kind) {
  const auto number = static_cast<std::size_t>(kind);
  return number < std::size(kKinds) ? kKinds[number].name : "?";
}

InputKind recogniseInput(const std::string& path, const InputOptions& options, std::string* guess) {
  if (!options.kind.empty()) {
    const InputKind kind = requireKind(options.kind);
    return fs::path(path).extension() == ".xvm" ? InputKind::map : kind;
  }
  std::error_code failed;
  const fs::file_status status = fs::status(setupPathOf(path).file, failed);
  if (path == "-" ||
      (fs::exists(status) && !fs::is_directory(status) && !fs::is_regular_file(status)))
    throw Error(
        path,
        "of stdin and pipes only `xview follow -` reads; write what comes to a file and name "
        "that");
  if (!fs::exists(status)) throw Error(path, "no such file or folder");
  return fs::is_directory(status) ? recogniseFolder(path) : recogniseFile(path, options, guess);
}

FrameRange parseFrameRange(const std::string& text) {
  const std::string expected = "--frames " + text + ": expected A:B or A:B:STEP";
  std::vector<std::string> parts;
  std::istringstream words(text + ":");
  for (std::string word; std::getline(words, word, ':');) parts.push_back(word);
  if (parts.size() < 2 || parts.size() > 3) throw UsageError(expected);
  const auto position = [&](const std::string& word) -> std::optional<std::size_t> {
    if (word.empty()) return std::nullopt;
    const auto value = numberFrom<std::int64_t>(word);
    if (!value || *value < 0) throw UsageError(expected + ", whole numbers >= 0");
    return static_cast<std::size_t>(*value);
  };
  FrameRange range;
  range.begin = position(parts[0]).value_or(0);
  range.end = position(parts[1]);
  if (parts.size() == 3) range.step = position(parts[2]).value_or(1);
  if (range.step == 0) throw UsageError(expected + ", STEP must be >= 1");
  if (range.end && *range.end <= range.begin) throw UsageError(expected + ", B must be > A");
  return range;
}

void moveCloud(const Eigen::Affine3d& moved, LabelledCloud& cloud) {
  const Eigen::Matrix3f linear = moved.linear().cast<float>();
  const float scale = std::cbrt(linear.determinant());
  cloud.origin = moved * cloud.origin;
  for (Point& p : cloud.points) {
    p.getVector3fMap() = linear * p.getVector3fMap();
    p.sigma *= scale;
  }
}

std::unique_ptr<FrameSource> openRecording(const std::string& path, const InputOptions& options) {
  std::string guess;
  InputKind kind = recogniseInput(path, options, &guess);
  if (kind == InputKind::graph && !guess.empty()) kind = InputKind::cloud;  // who wants points
  const auto list = kKinds[static_cast<std::size_t>(kind)].list;
  if (!list)
    throw Error(path, fmt::format("is a {}, expected something with points", toString(kind)));
  RecordingListing listing = list(path, options);
  if (!guess.empty()) listing.notes.push_back(guess);
  if (!options.mount.empty() && kind != InputKind::airsim)
    listing.notes.push_back("--mount is for AirSim recordings and changes nothing here");
  return makeRecording(path, std::move(listing), options.frames, options.moved);
}

void writeRecording(const std::string& folder, const FrameSource& source,
                    const std::vector<Eigen::Isometry3d>& truth, int threads,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  AtomicFolder whole(folder);
  writeParts(whole.temporaryPath(), source, truth, threads, progress);
  // Images without poses and poses without scans are no recording.
  whole.commit({"instance", "label", "labels", "depth", "classes.yaml", "camera.yaml", "calib.txt",
                "times.txt", "poses.txt", "velodyne"});
}

}  // namespace xview::io
