// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <map>

#include "inputs.h"
#include "tool.h"
#include "xview/io/cloud_files.h"
#include "xview/map/map_store.h"
#include "xview/measure_size.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

/// What some points, pixels or vertices hold: how many of each class, and where.
struct Census {
  std::map<std::uint32_t, std::size_t> counts;
  Eigen::AlignedBox3d bounds;  ///< [m]
  std::size_t measured = 0;    ///< points that are there, or pixels with depth
  std::size_t size = 0;        ///< points or pixels
  std::string camera;          ///< in words; empty if there is none
};

Census censusOf(const LabelledCloud& cloud) {
  Census census;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ++census.counts[cloud.points[i].label];
    census.bounds.extend(cloud.position(i));
  }
  census.size = census.measured = cloud.size();
  return census;
}

Census censusOf(const SemanticGraph& graph) {
  Census census;
  for (const Vertex& vertex : graph.vertices) {
    ++census.counts[vertex.label];
    census.bounds.extend(vertex.position);
  }
  census.size = census.measured = graph.size();
  return census;
}

/// In the frame of the sensor; a camera frame has no bounds.
Census censusOf(const Frame& frame) {
  if (frame.sensor != Sensor::camera) return censusOf(frame.cloud);
  Census census;
  for (const std::uint16_t label : frame.label.pixels) ++census.counts[label];
  for (const float depth : frame.depth.pixels) census.measured += depth > 0;
  census.size = frame.depth.pixels.size();
  census.camera = fmt::format("{} x {} px, fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}",
                              frame.camera.width, frame.camera.height, frame.camera.fx,
                              frame.camera.fy, frame.camera.cx, frame.camera.cy);
  return census;
}

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

void printClasses(const Census& census, const LabelSet& labels, const char* unit) {
  std::size_t total = 0;
  for (const auto& [id, count] : census.counts) total += count;
  printRow("classes", fmt::format("{}{}{}", census.counts.size(),
                                  labels.name().empty() ? "" : " of label set ", labels.name()));
  fmt::print("{:>6}  {:<24}{:<10}{:>14}\n", "id", "name", "role", unit);
  for (const auto& [id, count] : census.counts) {
    const char* role = labels.find(id) ? toString(labels.role(id)) : "unknown";
    fmt::print("{:>6}  {:<24}{:<10}{:>14}{:>7.2f} %\n", id, labels.className(id), role, count,
               100.0 * static_cast<double>(count) / static_cast<double>(total));
  }
}

void printGraph(const SemanticGraph& graph, const LabelSet& labels) {
  const Census census = censusOf(graph);
  printRow("graph", fmt::format("{} vertices, {} edges, {} connected parts", graph.size(),
                                graph.edgeCount(), componentCount(graph)));
  if (graph.space == GraphSpace::image) printRow("graph space", "image");
  printBounds("bounds", census.bounds);
  printClasses(census, labels, "vertices");
}

void printMap(const std::string& path) {
  const map::MapSummary summary = map::readMapSummary(path);
  printRow("version", fmt::format("schema {}, written by {}", summary.schema_version,
                                  summary.program_version));
  printRow("size", summary.size);
  printRow("holds", fmt::format("{} key frames, {} points, {} plan samples", summary.keyframes,
                                summary.cloud_points, summary.plan_samples));
  for (const std::string& source : summary.sources) printRow("source", source);
  const map::SemanticMap map = map::loadMap(path);
  printGraph(map.graph, map.labels);
}

/// What lengths are usual there, given or measured.
template <class Measured>
void printSize(const Measured& data, const Options& options) {
  if (const auto given = parseSize(options.size)) return printRow("size", sizeText(*given));
  const MeasuredSize found = measureSize(data);
  printRow("size", fmt::format("{} ({})", sizeText(found.size), found.reason));
}

void printRecording(const FrameSource& source, const Job& job) {
  if (source.size() == 0) throw Error(source.name(), "no frames");
  printSize(std::vector<const FrameSource*>{&source}, job.options);
  std::vector<Census> frames;
  forEachFrame(
      source, job, "info", [](const Frame& frame) { return censusOf(frame); },
      [&](Census census) { frames.push_back(std::move(census)); });
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
    const io::InputKind kind = io::recogniseInput(path, input_.parsed());
    printRow("path", path);
    printRow("kind", toString(kind));
    if (kind == io::InputKind::map) {
      printMap(path);
    } else if (kind == io::InputKind::graph) {
      const LabelledGraph file = readLabelledGraph(path, input_.parsed(), job);
      printSize(file.graph, job.options);
      printGraph(file.graph, file.labels);
    } else if (kind == io::InputKind::cloud) {
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
    const io::InputOptions options = input_.parsed();
    const io::CloudFields fields{options.label_field, options.instance_field};
    const io::CloudHeader header = io::readCloudHeader(path, fields);
    const auto or_none = [](const std::string& field) {
      return field.empty() ? "no such field" : field;
    };
    printRow("format", header.format);
    printRow("points", std::to_string(header.points));
    printRow("fields", fmt::format("{}", fmt::join(header.fields, " ")));
    printRow("label", or_none(header.label_field));
    printRow("instance", or_none(header.instance_field));
    if (header.label_field.empty())
      return printBounds("bounds", censusOf(io::readCloud(path, fields, false)).bounds);
    const auto source = openInput(path, options, job);
    printSize(std::vector<const FrameSource*>{source.get()}, job.options);
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
