// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"

namespace xview::tools {
namespace {

class LiftCommand final : public Command {
 public:
  Description describe() const override {
    return {"lift",
            "INPUT CLOUD.pcd|.ply|.las",
            "depth+label frames -> one labelled cloud in the odometry frame",
            "Every measurement of a class that is not ignored becomes one point. The cloud is "
            ".pcd, .ply or .las by the ending of its name. Of a map (.xvm) it is the points that "
            "the map keeps. A cloud that is moved with --transform alone is the same cloud again "
            "with all its points and fields. With --tiles CLOUD is a folder as Autoware divides "
            "its map.",
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
    flags.add("--tiles", tiles_m_, "write a folder of tiles that are so wide; 0 = one file [m]");
  }

  ExitCode run(const Job& job) override {
    if (!(voxel_m_ >= 0)) throw UsageError(fmt::format("--voxel {}, must be >= 0", voxel_m_));
    if (tiles_m_ < 0) throw UsageError(fmt::format("--tiles {}, must be >= 0", tiles_m_));
    if (tiles_m_ == 0) requireCloudPath(job.operands[1]);
    io::InputOptions input = input_.parsed();
    if (!transform_.empty()) input.moved = io::readMatrix(transform_);
    Stopwatch watch;
    if (isOnlyMoved(job, input)) {
      const LabelSet labels = io::openRecording(job.operands[0], input)->labels();
      for (const std::string& note : io::copyCloud(
               job.operands[0], job.operands[1], input.moved.value_or(Eigen::Affine3d::Identity()),
               labels.isGeneric() || labels.empty() ? nullptr : &labels))
        job.narrate.note(job.operands[0] + ": " + note);
      job.narrate.stage("lift", watch.lap_ms(), "the cloud with all its fields");
      return kDone;
    }
    const Lifted lifted = io::recogniseInput(job.operands[0], input) == io::InputKind::map
                              ? pointsOfMap(job.operands[0], input.moved)
                              : pointsOfFrames(job, input);
    write(job.operands[1], lifted, job.narrate);
    job.narrate.stage("lift", watch.lap_ms(), lifted.story);
    return kDone;
  }

 private:
  struct Lifted {
    LabelledCloud cloud;
    LabelSet labels;
    std::string story;  ///< what became of it
  };

  /// Whether nothing is asked of one cloud but that it be moved, or be another LAS.
  bool isOnlyMoved(const Job& job, const io::InputOptions& input) const {
    const bool stays_las = endingOf(job.operands[0]) == ".las" &&
                           endingOf(job.operands[1]) == ".las" &&
                           job.options.lift.max_range_m == LiftOptions().max_range_m &&
                           job.options.lift.min_range_m == LiftOptions().min_range_m;
    return (input.moved || stays_las) && tiles_m_ == 0 && voxel_m_ == 0 && input.labels.empty() &&
           input.label_field.empty() && input.instance_field.empty() && !input.frames.begin &&
           !input.frames.end && input.frames.step == 1 && io::isCloudFile(job.operands[0]) &&
           !std::filesystem::is_directory(job.operands[0]) &&
           io::recogniseInput(job.operands[0], input) == io::InputKind::cloud;
  }

  /// What has no labels gets them as it lies and is long when it was moved.
  Lifted pointsOfFrames(const Job& job, const io::InputOptions& input) const {
    const auto source = openInput(job.operands[0], input, job);
    LiftCounts counts;
    LabelledCloud cloud = liftAll(*source, job, voxel_m_, &counts);
    std::string story = fmt::format(
        "{} {}, {} points; left out: {} {}, {} out of range, {} of ignored classes", source->size(),
        source->size() == 1 ? "frame" : "frames", cloud.size(), counts.no_depth,
        source->sensor() == Sensor::camera ? "without depth" : "not finite", counts.out_of_range,
        counts.ignored_class);
    return {std::move(cloud), source->labels(), std::move(story)};
  }

  Lifted pointsOfMap(const std::string& path, const std::optional<Eigen::Affine3d>& moved) const {
    map::SemanticMap map = map::unpacked(map::openMap(path));
    if (map.cloud.empty()) throw Error(path, "the map keeps no points; make it of a recording");
    if (moved) io::moveCloud(*moved, map.cloud);
    if (voxel_m_ > 0) map.cloud = thinByVoxel(map.cloud, voxel_m_);
    std::string story = fmt::format("{} points", map.cloud.size());
    return {std::move(map.cloud), map.labels, std::move(story)};
  }

  void write(const std::string& path, const Lifted& lifted, const Narrative& narrate) const {
    if (tiles_m_ == 0)
      writeCloud(path, lifted.cloud, lifted.labels);
    else
      io::writeTiles(path, lifted.cloud, tiles_m_, &lifted.labels);
    noteDoubles(path, lifted.cloud, narrate);
  }

  InputFlags input_;
  std::string transform_;
  double voxel_m_ = 0;
  int tiles_m_ = 0;
};

}  // namespace

std::unique_ptr<Command> makeLift() { return std::make_unique<LiftCommand>(); }

}  // namespace xview::tools
