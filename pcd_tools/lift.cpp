// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/io/pose_files.h"
#include "xview/types/error.h"
#include "xview/types/localization.h"

namespace xview::tools {
namespace {

/// Its classes and instances stay; a far origin takes the translation, so that millimetres stay.
void move(LabelledCloud& cloud, const Eigen::Affine3d& T_out_in) {
  const Eigen::Matrix3f turn = T_out_in.linear().cast<float>();
  cloud.origin = T_out_in * cloud.origin;
  for (Point& p : cloud.points) p.getVector3fMap() = turn * p.getVector3fMap();
}

class LiftCommand final : public Command {
 public:
  Description describe() const override {
    return {"lift",
            "INPUT CLOUD.pcd",
            "depth+label frames -> one labelled cloud in the odometry frame",
            "Every measurement of a class that is not ignored becomes one point. The cloud is .pcd "
            "or .ply by the ending of its name. Of a labelled cloud it is the same cloud again, "
            "moved with --transform, its classes kept.",
            "xview lift town/forward --frames 0:30 town.pcd",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--voxel", voxel_m_,
              "thin the cloud to one point per voxel and class; 0 = keep all [m]");
    flags.add("--transform", transform_,
              "move the cloud by these 4 x 4 numbers (localize --matrix)");
  }

  ExitCode run(const Job& job) override {
    if (!(voxel_m_ >= 0)) throw UsageError(fmt::format("--voxel {}, must be >= 0", voxel_m_));
    requireCloudPath(job.operands[1]);
    Eigen::Affine3d T_out_odom = Eigen::Affine3d::Identity();
    if (!transform_.empty()) T_out_odom = io::readMatrix(transform_);
    Stopwatch watch;
    const auto source = openInput(job.operands[0], input_.parsed(), job);
    graph::LiftCounts counts;
    LabelledCloud cloud = liftAll(*source, job, voxel_m_, &counts);
    if (!transform_.empty()) move(cloud, T_out_odom);
    writeCloud(job.operands[1], cloud, source->labels());
    job.narrate.stage("lift", watch.lap_ms(),
                      fmt::format("{} frames, {} points; left out: {} without depth, {} out of "
                                  "range, {} of ignored classes",
                                  source->size(), cloud.size(), counts.no_depth,
                                  counts.out_of_range, counts.ignored_class));
    return kDone;
  }

 private:
  InputFlags input_;
  std::string transform_;
  double voxel_m_ = 0;
};

}  // namespace

std::unique_ptr<Command> makeLift() { return std::make_unique<LiftCommand>(); }

}  // namespace xview::tools
