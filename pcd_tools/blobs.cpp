// SPDX-License-Identifier: BSD-3-Clause
#include "place/blobs.h"

#include <fmt/core.h>

#include <map>

#include "base/user_text.h"
#include "inputs.h"
#include "outputs.h"
#include "place/measure_size.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/options.h"

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
    fmt::print("{:>6}  {:<23} {:>8}{:>12}\n", label, printable(labels.className(label)), sum.blobs,
               sum.points);
  }
}

class BlobsCommand final : public Command {
 public:
  Description describe() const override {
    return {"blobs",
            "INPUT BLOBS.pcd",
            "per-class Euclidean clusters (label = class, instance = blob)",
            "Blobs are numbered from 1; instance 0 marks points of clusters that are too small. "
            "Points are thinned to --blobs.voxel_m first; 0 keeps them all.",
            "xview blobs scan.pcd blobs.pcd --blobs.tolerance_m 0.3",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& given) override {
    if (usesImageRegions(given.options))
      throw UsageError("--graph_space " + given.options.graph_space +
                       ": blobs are clusters of points; xview graph makes one of image regions");
    requireCloudPath(given.operands[1]);
    const auto source = openInput(given.operands[0], input_.parsed(), given);
    Job job = given;
    job.options =
        atSize(given.options,
               sizeFor(given.options, std::vector{static_cast<const FrameSource*>(source.get())}));
    Stopwatch watch;
    LabelledCloud cloud = liftAll(*source, job, job.options.blobs.voxel_m);
    job.narrate.stage("lift", watch.lap_ms(),
                      fmt::format("{} frames, {} points", source->size(), cloud.size()));
    std::vector<int> blob_of_point;
    const std::vector<Blob> blobs =
        extractBlobs(cloud, source->labels(), job.options.blobs, &blob_of_point);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      cloud.points[i].instance = static_cast<std::uint32_t>(blob_of_point[i] + 1);
    job.narrate.stage("blobs", watch.lap_ms(), fmt::format("{} blobs", blobs.size()));
    writeCloud(job.operands[1], cloud, source->labels());
    printClasses(blobs, source->labels());
    return kDone;
  }

 private:
  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeBlobs() { return std::make_unique<BlobsCommand>(); }

}  // namespace xview::tools
