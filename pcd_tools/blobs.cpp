// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/blobs.h"

#include <fmt/core.h>

#include <map>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/depth_plausibility.h"
#include "xview/graph/clean_labels.h"
#include "xview/graph/lift.h"
#include "xview/measure_size.h"
#include "xview/options.h"
#include "xview/types/localization.h"

namespace xview::tools {
namespace {

/// One line per class: how many blobs, how many points in them.
void printClasses(const std::vector<Blob>& blobs, const LabelSet& labels) {
  struct Sum {
    std::size_t blobs = 0, points = 0;
  };
  std::map<std::uint32_t, Sum> sums;
  for (const Blob& blob : blobs) {
    ++sums[blob.label].blobs;
    sums[blob.label].points += blob.points;
  }
  fmt::print("{:>6}  {:<24}{:>8}{:>12}\n", "class", "name", "blobs", "points");
  for (const auto& [label, sum] : sums) {
    fmt::print("{:>6}  {:<24}{:>8}{:>12}\n", label, labels.className(label), sum.blobs, sum.points);
  }
}

/// The points of a cloud with its blobs, numbered from 1 as its instances.
struct BlobbedCloud {
  LabelledCloud cloud;
  std::vector<Blob> blobs;
};

BlobbedCloud clusterCloud(const FrameSource& source, const Job& job) {
  Stopwatch watch;
  BlobbedCloud result;
  LabelledCloud& cloud = result.cloud;
  cloud = liftAll(source, job, job.options.blobs.voxel_m);
  job.narrate.stage("lift", watch.lap_ms(),
                    fmt::format("{} frames, {} points", source.size(), cloud.size()));
  std::vector<int> blob_of_point;
  result.blobs = graph::extractBlobs(cloud, source.labels(), job.options.blobs, &blob_of_point);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.points[i].instance = static_cast<std::uint32_t>(blob_of_point[i] + 1);
  job.narrate.stage("blobs", watch.lap_ms(), fmt::format("{} blobs", result.blobs.size()));
  return result;
}

/// Blobs of one frame only, its pixels lifted.
struct FrameRegions {
  BlobbedCloud regions;
  graph::LiftCounts counts;
  Eigen::Vector3d sensor;
};

FrameRegions regionsOfFrame(Frame frame, const LabelSet& labels, const Options& options) {
  frame.label = graph::cleanLabels(frame.label, labels, options.clean);
  graph::ImageBlobs found =
      graph::extractImageBlobs(frame, labels, graph::maxRange(frame, options.lift));
  frame.instance = LabelImage(frame.label.width, frame.label.height);
  for (std::size_t i = 0; i < frame.instance.pixels.size(); ++i)
    frame.instance.pixels[i] = static_cast<std::uint16_t>(found.blob_of_pixel.pixels[i] + 1);
  FrameRegions result;
  result.regions.cloud = lift(frame, labels, options.lift, &result.counts);
  result.regions.blobs = std::move(found.blobs);
  result.sensor = frame.T_odom_sensor.translation();
  return result;
}

BlobbedCloud regionsOfImages(const FrameSource& source, const Job& job) {
  requireGraphSpace(job.options, source.sensor(), source.name());
  Stopwatch watch;
  BlobbedCloud result;
  DepthPlausibility depths;
  forEachFrame(
      source, job, "blobs",
      [&](Frame frame) { return regionsOfFrame(std::move(frame), source.labels(), job.options); },
      [&](FrameRegions frame) {
        auto& [cloud, blobs] = frame.regions;
        depths.add(frame.counts, cloud, frame.sensor);
        if (job.options.blobs.voxel_m > 0)
          cloud = graph::thinByVoxel(cloud, job.options.blobs.voxel_m);
        const auto before = static_cast<std::uint32_t>(result.blobs.size());
        for (Point& point : cloud.points) point.instance += point.instance > 0 ? before : 0;
        result.cloud.append(cloud);
        result.blobs.insert(result.blobs.end(), blobs.begin(), blobs.end());
      });
  depths.require(source);
  job.narrate.stage("blobs", watch.lap_ms(),
                    fmt::format("{} frames, {} points, {} image blobs", source.size(),
                                result.cloud.size(), result.blobs.size()));
  return result;
}

class BlobsCommand final : public Command {
 public:
  Description describe() const override {
    return {"blobs",
            "INPUT BLOBS.pcd",
            "per-class Euclidean clusters (label = class, instance = blob)",
            "Blobs are numbered from 1; instance 0 marks points of clusters that are too small. "
            "Points are thinned to --blobs.voxel_m first; 0 keeps them all. With --graph_space "
            "image or regions the blobs are the regions of each depth+label frame, as in the "
            "paper; merging over frames is left to xview graph.",
            "xview blobs scan.pcd blobs.pcd --blobs.tolerance_m 0.3",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& given) override {
    requireCloudPath(given.operands[1]);
    const auto source = openInput(given.operands[0], input_.parsed(), given);
    Job job = given;
    job.options =
        atSize(given.options,
               sizeFor(given.options, std::vector{static_cast<const FrameSource*>(source.get())}));
    const BlobbedCloud result =
        usesImageRegions(job.options) ? regionsOfImages(*source, job) : clusterCloud(*source, job);
    writeCloud(job.operands[1], result.cloud, source->labels());
    printClasses(result.blobs, source->labels());
    return kDone;
  }

 private:
  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeBlobs() { return std::make_unique<BlobsCommand>(); }

}  // namespace xview::tools
