// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/blobs.h"

#include <fmt/core.h>

#include <map>

#include "commands.h"
#include "frames_to_cloud.h"
#include "inputs.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

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

class BlobsCommand final : public Command {
 public:
  Description describe() const override {
    return {"blobs",
            "INPUT BLOBS.pcd",
            "per-class Euclidean clusters (label = class, instance = blob)",
            "Blobs are numbered from 1; instance 0 marks points of clusters that are too small. "
            "Points are thinned to\n"
            "--blobs.voxel_m first; 0 keeps them all.",
            "xview blobs scan.pcd blobs.pcd --blobs.tolerance_m 0.3",
            2,
            2};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& job) override {
    checkCloudEnding(job.operands[1]);
    Stopwatch watch;
    const auto source = openInput(job.operands[0], input_.parsed(), job);
    LiftCounts counts;
    LabelledCloud cloud = liftAll(*source, job, counts);
    if (job.options.blobs.voxel_m > 0) cloud = thinByVoxel(cloud, job.options.blobs.voxel_m);
    job.narrate.stage("lift", watch.lap_ms(),
                      fmt::format("{} frames, {} points", source->size(), cloud.size()));

    std::vector<int> blob_of_point;
    const std::vector<Blob> blobs =
        extractBlobs(cloud, source->labels(), job.options.blobs, &blob_of_point);
    cloud.instances.resize(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i)
      cloud.instances[i] = static_cast<std::uint32_t>(blob_of_point[i] + 1);
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
