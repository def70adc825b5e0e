// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <algorithm>
#include <filesystem>

#include "layouts.h"
#include "xview/types/error.h"
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
    const std::string ending = entry.path().extension().string();
    if (ending == ".pcd" || ending == ".ply" || ending == ".bin") return true;
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

InputKind recogniseFile(const std::string& path, std::string* guess) {
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".xvm") return InputKind::map;
  if (ending == ".bin") return InputKind::semantic_kitti;
  if (ending == ".pcd") return InputKind::cloud;
  if (ending == ".ply") return holdsGraph(path, guess) ? InputKind::graph : InputKind::cloud;
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

}  // namespace

const char* toString(InputKind kind) {
  static constexpr const char* kNames[] = {
      "sequence", "semantic_kitti", "cloud",    "cloud_folder",  "graph", "map",
      "synthia",  "airsim",         "tum_rgbd", "virtual_kitti", "carla"};
  return kind <= kLastKind ? kNames[static_cast<int>(kind)] : "?";
}

InputKind recogniseInput(const std::string& path, const InputOptions& options, std::string* guess) {
  if (!options.kind.empty()) {
    const InputKind kind = requireKind(options.kind);
    return fs::path(path).extension() == ".xvm" ? InputKind::map : kind;
  }
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (!fs::exists(status)) throw Error(path, "no such file or folder");
  return fs::is_directory(status) ? recogniseFolder(path) : recogniseFile(path, guess);
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
  std::string guess;
  InputKind kind = recogniseInput(path, options, &guess);
  if (kind == InputKind::graph && !guess.empty()) kind = InputKind::cloud;  // who wants points
  RecordingListing listing = listKind(path, kind, options);
  if (!guess.empty()) listing.notes.push_back(guess);
  if (!options.mount.empty() && kind != InputKind::airsim)
    listing.notes.push_back("--mount is for AirSim recordings and changes nothing here");
  return makeRecording(path, std::move(listing), options.frames);
}

}  // namespace xview::io
