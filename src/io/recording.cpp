// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/recording.h"

#include <filesystem>
#include <vector>

#include "datasets/datasets.h"
#include "input_recognition.h"
#include "number_words.h"
#include "recording_layouts.h"
#include "xview/types/error.h"

namespace xview {
namespace {

RecordingListing listFrames(const std::string& path, InputKind kind, const InputOptions& options) {
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
  const std::filesystem::path file(path);
  return options.kind.empty() && file.extension() == ".ply" &&
         std::filesystem::is_regular_file(file) && plyContent(path) == PlyContent::bare;
}

}  // namespace

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
  return makeRecording(path, listFrames(path, kind, options), options.frames);
}

}  // namespace xview
