// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <map>

#include "commands.h"
#include "inputs.h"
#include "xview/io/cloud_files.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/parallel.h"

namespace xview::tools {
namespace {

using Counts = std::map<std::uint32_t, std::size_t>;

void printRow(const std::string& name, const std::string& value) {
  fmt::print("{:<14}{}\n", name, value);
}

void printBounds(const std::string& name, const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return;
  const Eigen::Vector3d a = box.min(), b = box.max(), size = box.sizes();
  printRow(
      name,
      fmt::format(
          "x {:.2f} .. {:.2f}, y {:.2f} .. {:.2f}, z {:.2f} .. {:.2f} m ({:.1f} x {:.1f} x {:.1f})",
          a.x(), b.x(), a.y(), b.y(), a.z(), b.z(), size.x(), size.y(), size.z()));
}

void printClasses(const Counts& counts, const LabelSet& labels, const char* unit) {
  std::size_t total = 0;
  for (const auto& [id, count] : counts) total += count;
  fmt::print("classes       {}{}{}\n", counts.size(), labels.name().empty() ? "" : " of label set ",
             labels.name());
  fmt::print("{:>6}  {:<24}{:<10}{:>14}\n", "id", "name", "role", unit);
  for (const auto& [id, count] : counts) {
    const char* role = labels.find(id) ? toString(labels.role(id)) : "unknown";
    fmt::print("{:>6}  {:<24}{:<10}{:>14}{:>7.2f} %\n", id, labels.className(id), role, count,
               100.0 * static_cast<double>(count) / static_cast<double>(total));
  }
}

void countLabels(const LabelledCloud& cloud, Counts& counts, Eigen::AlignedBox3d& bounds) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ++counts[cloud.points[i].label];
    bounds.extend(cloud.position(i));
  }
}

/// What one frame holds, in its own frame of reference.
struct FrameSummary {
  Counts counts;
  Eigen::AlignedBox3d bounds;
  std::size_t measured = 0, size = 0;
  std::string shape;
};

FrameSummary summarise(const Frame& frame) {
  FrameSummary summary;
  if (frame.sensor != Sensor::camera) {
    countLabels(frame.cloud, summary.counts, summary.bounds);
    summary.size = summary.measured = frame.cloud.size();
    return summary;
  }
  for (const std::uint16_t label : frame.label.pixels) ++summary.counts[label];
  for (const float depth : frame.depth.pixels) summary.measured += depth > 0;
  summary.size = frame.depth.pixels.size();
  summary.shape = fmt::format("{} x {} px, fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}",
                              frame.camera.width, frame.camera.height, frame.camera.fx,
                              frame.camera.fy, frame.camera.cx, frame.camera.cy);
  return summary;
}

class InfoCommand final : public Command {
 public:
  Description describe() const override {
    return {"info", "FILE|DIR", "what is it: kind, classes and counts, bounds, poses, versions",
            "Reads everything, so that what info accepts the other commands accept as well.",
            "xview info town/forward"};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& job) override {
    const std::string& path = job.operands[0];
    const InputKind kind = recogniseInput(path, input_.parsed());
    printRow("path", path);
    printRow("kind", toString(kind));
    switch (kind) {
      case InputKind::map:
        printMap(path);
        break;
      case InputKind::graph:
        printGraph(path, job);
        break;
      case InputKind::cloud:
        printCloud(path);
        break;
      default:
        printRecording(path, job);
    }
    return kDone;
  }

 private:
  void printMap(const std::string& path) const {
    const MapSummary summary = readMapSummary(path);
    printRow("version", fmt::format("schema {}, written by {}", summary.schema_version,
                                    summary.program_version));
    printRow("size", fmt::format("{} vertices, {} edges, {} key frames, {} points, {} plan samples",
                                 summary.vertices, summary.edges, summary.keyframes,
                                 summary.cloud_points, summary.plan_samples));
    for (const std::string& source : summary.sources) printRow("source", source);
    const SemanticMap map = loadMap(path);
    Counts counts;
    Eigen::AlignedBox3d bounds;
    for (const Vertex& vertex : map.graph.vertices) {
      ++counts[vertex.label];
      bounds.extend(vertex.position);
    }
    printBounds("bounds", bounds);
    printClasses(counts, map.labels, "vertices");
  }

  void printGraph(const std::string& path, const Job& job) const {
    const LabelledGraph file = readLabelledGraph(path, input_, job.options);
    Counts counts;
    Eigen::AlignedBox3d bounds;
    for (const Vertex& vertex : file.graph.vertices) {
      ++counts[vertex.label];
      bounds.extend(vertex.position);
    }
    printRow("size", fmt::format("{} vertices, {} edges, {} connected parts", file.graph.size(),
                                 file.graph.edgeCount(), componentCount(file.graph)));
    printBounds("bounds", bounds);
    printClasses(counts, file.labels, "vertices");
  }

  /// A single file; one without labels is described as well, as what it lacks is worth knowing.
  void printCloud(const std::string& path) const {
    const InputOptions options = input_.parsed();
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".pcd" || ending == ".ply") {
      const CloudFields fields{options.label_field, options.instance_field};
      const CloudHeader header = readCloudHeader(path, fields);
      printRow("format", header.format);
      printRow("points", std::to_string(header.points));
      printRow("fields", fmt::format("{}", fmt::join(header.fields, " ")));
      printRow("label", header.label_field.empty() ? "no such field" : header.label_field);
      printRow("instance", header.instance_field.empty() ? "no such field" : header.instance_field);
      if (header.label_field.empty()) {
        Counts unlabelled;
        Eigen::AlignedBox3d bounds;
        countLabels(readCloud(path, fields, false), unlabelled, bounds);
        printBounds("bounds", bounds);
        return;
      }
    }
    const auto source = openRecording(path, options);
    const FrameSummary summary = summarise(source->read(0));
    printRow("finite", fmt::format("{} points", summary.measured));
    printBounds("bounds", summary.bounds);
    printClasses(summary.counts, source->labels(), "points");
  }

  void printRecording(const std::string& path, const Job& job) const {
    const auto source = openRecording(path, input_.parsed());
    const Progress progress = job.narrate.progress("info");
    std::vector<FrameSummary> frames(source->size());
    std::size_t done = 0;
    constexpr std::size_t kBatch = 16;
    for (; done < frames.size(); done += std::min(kBatch, frames.size() - done)) {
      parallelFor(std::min(kBatch, frames.size() - done), job.options.threads,
                  [&](std::size_t i) { frames[done + i] = summarise(source->read(done + i)); });
      if (progress) progress(done, frames.size());
    }
    if (progress) progress(done, frames.size());
    printFrames(*source, frames);
  }

  static void printFrames(const FrameSource& source, const std::vector<FrameSummary>& frames) {
    Counts counts;
    Eigen::AlignedBox3d bounds;
    std::size_t measured = 0, size = 0;
    double length_m = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (const auto& [id, count] : frames[i].counts) counts[id] += count;
      measured += frames[i].measured;
      size += frames[i].size;
      bounds.extend(source.pose(i).translation());
      if (i > 0)
        length_m += (source.pose(i).translation() - source.pose(i - 1).translation()).norm();
    }
    const std::size_t last = frames.size() - 1;
    if (frames.empty()) throw Error(source.name(), "no frames");
    printRow("frames",
             fmt::format("{}, numbers {} .. {}, {:.3f} s", frames.size(), source.number(0),
                         source.number(last), source.stamp(last) - source.stamp(0)));
    if (!frames[0].shape.empty()) printRow("camera", frames[0].shape);
    printRow("measured", fmt::format("{} of {} {}", measured, size,
                                     frames[0].shape.empty() ? "points" : "pixels"));
    printRow("path length", fmt::format("{:.1f} m", length_m));
    printBounds("positions", bounds);
    printClasses(counts, source.labels(), frames[0].shape.empty() ? "points" : "pixels");
  }

  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeInfo() { return std::make_unique<InfoCommand>(); }

}  // namespace xview::tools
