// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "census.h"
#include "commands.h"
#include "inputs.h"
#include "xview/io/cloud_files.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview::tools {
namespace {

void printGraph(const SemanticGraph& graph, const LabelSet& labels) {
  const Census census = censusOf(graph);
  printRow("graph", fmt::format("{} vertices, {} edges, {} connected parts", graph.size(),
                                graph.edgeCount(), componentCount(graph)));
  if (graph.space == GraphSpace::image) printRow("graph space", "image");
  printBounds("bounds", census.bounds);
  printClasses(census, labels, "vertices");
}

void printMap(const std::string& path) {
  const MapSummary summary = readMapSummary(path);
  printRow("version", fmt::format("schema {}, written by {}", summary.schema_version,
                                  summary.program_version));
  printRow("size", fmt::format("{} key frames, {} points, {} plan samples", summary.keyframes,
                               summary.cloud_points, summary.plan_samples));
  for (const std::string& source : summary.sources) printRow("source", source);
  const SemanticMap map = loadMap(path);
  printGraph(map.graph, map.labels);
}

std::vector<Census> censusOfFrames(const FrameSource& source, const Job& job) {
  const Progress progress = job.narrate.progress("info");
  std::vector<Census> frames(source.size());
  constexpr std::size_t kBatch = 16;  // frames in memory at a time
  for (std::size_t first = 0; first < frames.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, frames.size() - first);
    parallelFor(count, job.options.threads,
                [&](std::size_t i) { frames[first + i] = censusOf(source.read(first + i)); });
    if (progress) progress(first + count, frames.size());
  }
  return frames;
}

void printRecording(const FrameSource& source, const Job& job) {
  if (source.size() == 0) throw Error(source.name(), "no frames");
  const std::vector<Census> frames = censusOfFrames(source, job);
  Census all;
  double length_m = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const auto& [id, count] : frames[i].counts) all.counts[id] += count;
    all.measured += frames[i].measured;
    all.size += frames[i].size;
    all.bounds.extend(source.pose(i).translation());
    if (i > 0) length_m += (source.pose(i).translation() - source.pose(i - 1).translation()).norm();
  }
  const std::size_t last = frames.size() - 1;
  const char* unit = frames[0].camera.empty() ? "points" : "pixels";
  printRow("frames", fmt::format("{}, numbers {} .. {}, {:.3f} s", frames.size(), source.number(0),
                                 source.number(last), source.stamp(last) - source.stamp(0)));
  if (!frames[0].camera.empty()) printRow("camera", frames[0].camera);
  printRow("measured", fmt::format("{} of {} {}", all.measured, all.size, unit));
  printRow("path length", fmt::format("{:.1f} m", length_m));
  printBounds("positions", all.bounds);
  printClasses(all, source.labels(), unit);
}

class InfoCommand final : public Command {
 public:
  Description describe() const override {
    return {"info", "FILE|DIR", "what is it: kind, classes and counts, bounds, poses, versions",
            "Reads everything, so that what info accepts the other commands accept as well; only a "
            "cloud without\nclasses is described, too.",
            "xview info town/forward"};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& job) override {
    const std::string& path = job.operands[0];
    const InputKind kind = recogniseInput(path, input_.parsed());
    printRow("path", path);
    printRow("kind", toString(kind));
    if (kind == InputKind::map) {
      printMap(path);
    } else if (kind == InputKind::graph) {
      const LabelledGraph file = readLabelledGraph(path, input_.parsed(), job.options);
      printGraph(file.graph, file.labels);
    } else if (kind == InputKind::cloud) {
      printCloud(path, job);
    } else {
      printRecording(*openInput(path, input_.parsed(), job), job);
    }
    return kDone;
  }

 private:
  /// A single PCD or PLY; one without labels is described as well, as what it lacks is worth
  /// knowing.
  void printCloud(const std::string& path, const Job& job) const {
    const InputOptions options = input_.parsed();
    const CloudFields fields{options.label_field, options.instance_field};
    const CloudHeader header = readCloudHeader(path, fields);
    const auto or_none = [](const std::string& field) {
      return field.empty() ? "no such field" : field;
    };
    printRow("format", header.format);
    printRow("points", std::to_string(header.points));
    printRow("fields", fmt::format("{}", fmt::join(header.fields, " ")));
    printRow("label", or_none(header.label_field));
    printRow("instance", or_none(header.instance_field));
    if (header.label_field.empty())
      return printBounds("bounds", censusOf(readCloud(path, fields, false)).bounds);
    const auto source = openInput(path, options, job);
    const Census census = censusOf(source->read(0));
    printRow("finite", fmt::format("{} points", census.measured));
    printBounds("bounds", census.bounds);
    printClasses(census, source->labels(), "points");
  }

  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeInfo() { return std::make_unique<InfoCommand>(); }

}  // namespace xview::tools
