// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "layouts.h"
#include "point_table.h"
#include "xview/types/error.h"
#include "xview/types/median.h"
#include "xview/types/nearest_word.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

// ---- what a path is

constexpr InputKind kLastKind = InputKind::carla;

InputKind requireKind(const std::string& name) {
  if (const auto kind = enumeratorNamed(name, kLastKind)) return *kind;
  std::vector<std::string> names;
  for (int i = 0; i <= static_cast<int>(kLastKind); ++i) {
    names.emplace_back(toString(static_cast<InputKind>(i)));
  }
  throw UsageError("--input-kind " + name + ": unknown, the nearest known one is " +
                   nearestWord(name, names));
}

[[noreturn]] void failBetween(const std::string& path, InputKind a, InputKind b,
                              const std::string& why) {
  throw Error(path, std::string("may be a ") + toString(a) + " or a " + toString(b) + " (" + why +
                        "); say which with --input-kind");
}

bool isOneOf(const std::string& name, std::initializer_list<const char*> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool hasClouds(const fs::path& folder) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string ending = entry.path().extension().string();
    if (isOneOf(ending, {".pcd", ".ply", ".bin"})) return true;
  }
  return false;
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
  if (kinds.empty() && hasClouds(folder)) kinds.push_back(InputKind::cloud_folder);
  if (kinds.size() > 1)
    failBetween(folder.string(), kinds[0], kinds[1], "it has the folders of both");
  if (kinds.empty()) {
    throw Error(folder.string(),
                "not a recording: expected camera.yaml with depth/, velodyne/, .pcd, .ply or .bin "
                "files, or the layout of a known data set");
  }
  return kinds[0];
}

/// What the header of a .ply says it holds.
enum class PlyContent {
  cloud,  ///< points with more than positions and labels, or too many for a graph
  graph,  ///< edges, or properties that only graphs have
  bare    ///< positions, integer labels and perhaps instances: may be either
};

PlyContent plyContent(const std::string& path) {
  constexpr std::size_t kMaxBareVertices = 100000;
  InputFile file(path);
  const FileLayout layout = readPlyHeader(file);
  const Element* vertices = layout.findElement("vertex");
  if (!vertices) throw Error(path, "no `element vertex` in the header");
  bool bare = vertices->rows < kMaxBareVertices, labelled = false;
  for (const Column& column : vertices->columns) {
    if (isOneOf(column.name, {"observations", "sigma", "extent_x"})) return PlyContent::graph;
    bare = bare && isOneOf(column.name, {"x", "y", "z", "label", "instance"});
    labelled = labelled || (column.name == "label" && isInteger(column.type));
  }
  if (labelled && layout.findElement("edge")) return PlyContent::graph;
  return bare && labelled ? PlyContent::bare : PlyContent::cloud;
}

/// Median distance of a vertex to the nearest other one, over some of the vertices [m].
double medianSpacing(const LabelledCloud& cloud) {
  constexpr std::size_t kProbes = 200;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kProbes);
  std::vector<float> nearest;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    float best = std::numeric_limits<float>::max();
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      if (j == i) continue;
      best = std::min(
          best,
          (cloud.points[i].getVector3fMap() - cloud.points[j].getVector3fMap()).squaredNorm());
    }
    nearest.push_back(best);
  }
  return std::sqrt(medianOf(std::move(nearest)));
}

/// True if no two vertices share an instance (but for none at all, 0).
bool instancesAreUnique(const LabelledCloud& cloud) {
  std::vector<std::uint32_t> ids;
  for (const Point& p : cloud.points) {
    if (p.instance != 0) ids.push_back(p.instance);
  }
  std::sort(ids.begin(), ids.end());
  const auto distinct = std::unique(ids.begin(), ids.end()) - ids.begin();
  return static_cast<double>(distinct) >= 0.95 * static_cast<double>(cloud.size());
}

/// A .ply with positions, labels and perhaps instances only: a bare graph or a labelled cloud.
InputKind recogniseBarePly(const std::string& path, const InputOptions& options) {
  constexpr double kGraphSpacing = 1.0, kCloudSpacing = 0.3;  // [m]
  const LabelledCloud cloud = readCloud(path, {options.label_field, options.instance_field});
  if (cloud.size() < 2) return InputKind::cloud;
  if (cloud.hasInstances() && instancesAreUnique(cloud)) return InputKind::graph;
  const double spacing = medianSpacing(cloud);
  if (spacing >= kGraphSpacing) return InputKind::graph;
  if (spacing <= kCloudSpacing) return InputKind::cloud;
  failBetween(path, InputKind::cloud, InputKind::graph,
              "its points are about " + std::to_string(spacing) + " m apart");
}

InputKind recognisePly(const std::string& path, const InputOptions& options) {
  const PlyContent content = plyContent(path);
  if (content == PlyContent::bare) return recogniseBarePly(path, options);
  return content == PlyContent::graph ? InputKind::graph : InputKind::cloud;
}

InputKind recogniseFile(const std::string& path, const InputOptions& options) {
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".xvm") return InputKind::map;
  if (ending == ".bin") return InputKind::semantic_kitti;
  if (ending == ".pcd") return InputKind::cloud;
  if (ending == ".ply") return recognisePly(path, options);
  throw Error(path, "not a known kind of file: expected .xvm, .ply, .pcd, .bin or a folder");
}

// ---- its frames

RecordingListing listKind(const std::string& path, InputKind kind, const InputOptions& options) {
  switch (kind) {
    case InputKind::sequence:
      return listSequence(path, options);
    case InputKind::semantic_kitti:
      return listSemanticKitti(path, options);
    case InputKind::cloud:
      return listCloud(path, options);
    case InputKind::cloud_folder:
      return listCloudFolder(path, options);
    case InputKind::synthia:
      return listSynthia(path, options);
    case InputKind::airsim:
      return listAirsim(path, options);
    case InputKind::tum_rgbd:
      return listTumRgbd(path, options);
    case InputKind::virtual_kitti:
      return listVirtualKitti(path, options);
    case InputKind::carla:
      return listCarla(path, options);
    case InputKind::graph:
    case InputKind::map:
      break;
  }
  throw Error(path, std::string("is a ") + toString(kind) + ", expected something with points");
}

/// Whoever asks for points gets them of a .ply that may be a graph or a cloud.
bool isBarePly(const std::string& path, const InputOptions& options) {
  const fs::path file(path);
  return options.kind.empty() && file.extension() == ".ply" && fs::is_regular_file(file) &&
         plyContent(path) == PlyContent::bare;
}

}  // namespace

const char* toString(InputKind kind) {
  static constexpr const char* kNames[] = {
      "sequence", "semantic_kitti", "cloud",    "cloud_folder",  "graph", "map",
      "synthia",  "airsim",         "tum_rgbd", "virtual_kitti", "carla"};
  return kind <= kLastKind ? kNames[static_cast<int>(kind)] : "?";
}

InputKind recogniseInput(const std::string& path, const InputOptions& options) {
  if (!options.kind.empty()) {
    const InputKind kind = requireKind(options.kind);
    return fs::path(path).extension() == ".xvm" ? InputKind::map : kind;
  }
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) throw Error(path, "no such file or folder");
  return fs::is_directory(status) ? recogniseFolder(path) : recogniseFile(path, options);
}

FrameRange parseFrameRange(const std::string& text) {
  const std::string expected = "--frames " + text + ": expected A:B or A:B:STEP";
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  if (parts.size() < 2 || parts.size() > 3) throw UsageError(expected);
  const auto position = [&](const std::string& word) -> std::optional<std::size_t> {
    if (word.empty()) return std::nullopt;
    const auto value = asInteger(word);
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

std::unique_ptr<FrameSource> openRecording(const std::string& path, const InputOptions& options) {
  const InputKind kind =
      isBarePly(path, options) ? InputKind::cloud : recogniseInput(path, options);
  return makeRecording(path, listKind(path, kind, options), options.frames);
}

}  // namespace xview::io
