// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

bool isCloudPath(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  return ending == ".pcd" || ending == ".ply";
}

class LabelCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "label",
        "INPUT OUT",
        "classes for a raw recording, from shapes",
        "Ground, walls, posts, foliage, low things, roofs, ceilings and tables are told by the "
        "shapes of the points; what\n"
        "INPUT has of labels is left aside. OUT is one cloud in the odometry frame, coloured by "
        "class (.pcd or .ply),\n"
        "or else a folder that becomes the labelled recording.",
        "xview label scan.pcd labelled.pcd && pcl_viewer labelled.pcd",
        2,
        2};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--voxel", voxel_m_,
              "thin the cloud to one point per voxel and class; 0 = keep all [m]");
  }

  ExitCode run(const Job& job) override {
    if (!(voxel_m_ >= 0)) throw UsageError(fmt::format("--voxel {}, must be >= 0", voxel_m_));
    const std::string& out = job.operands[1];
    if (isCloudPath(out)) requireCloudPath(out);
    Stopwatch watch;
    io::InputOptions options = input_.parsed();
    options.labels = "shapes";
    const auto source = openInput(job.operands[0], options, job);
    if (isCloudPath(out)) {
      writeCloud(out, liftAll(*source, job, voxel_m_), source->labels());
    } else {
      io::writeRecording(out, *source, {}, job.options.threads, job.narrate.progress("label"));
    }
    job.narrate.stage("label", watch.lap_ms(), fmt::format("{} frames: {}", source->size(), out));
    return kDone;
  }

 private:
  InputFlags input_;
  double voxel_m_ = 0;
};

}  // namespace

std::unique_ptr<Command> makeLabel() { return std::make_unique<LabelCommand>(); }

}  // namespace xview::tools
