// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <mutex>

#include "inputs.h"
#include "io/image_files.h"
#include "outputs.h"
#include "place/network.h"
#include "place/raw_recording.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/base/localization.h"
#include "xview/io/label_files.h"

namespace xview::tools {
namespace {

io::InputOptions labelsOnly(const std::string& labels) {
  io::InputOptions options;
  options.labels = labels;
  return options;
}

/// A recording of cameras with the classes that a network finds in its colours.
std::unique_ptr<FrameSource> labelledByNetwork(std::shared_ptr<const FrameSource> source,
                                               const std::string& model,
                                               const NetworkInput& input) {
  const LabelSet labels = *io::namedLabels(labelsOnly(input.labels), "");
  const std::shared_ptr<Network> network = Network::open(model, input);
  for (const std::uint32_t id : input.ids) {
    if (id != 0 && !labels.find(id))
      throw Error(model, fmt::format("its configuration has the id {}, which is no class of label "
                                     "set '{}'",
                                     id, labels.name()));
  }
  if (source->sensor() != Sensor::camera)
    throw UsageError("--net needs images, but " + source->name() + " has none");
  const auto one_at_a_time = std::make_shared<std::mutex>();
  const auto read = [source, network, one_at_a_time,
                     files = io::colorFiles(*source)](std::size_t index) {
    Frame frame = source->read(index);
    const ColorImage colors = io::readColors(files.at(index));
    const std::lock_guard<std::mutex> lock(*one_at_a_time);
    frame.label = network->label(colors, frame.depth.width, frame.depth.height);
    frame.instance = {};
    return frame;
  };
  return std::make_unique<RelabelledRecording>(source, labels, read);
}

class LabelCommand final : public Command {
 public:
  Description describe() const override {
    return {"label",
            "INPUT OUT",
            "classes for a raw recording, from shapes or by a network",
            "Ground, walls, posts, foliage, low things, roofs, ceilings and tables are told by the "
            "shapes of the points; what INPUT has of labels is left aside. OUT is one cloud in the "
            "odometry frame, coloured by class (.pcd or .ply), or else a folder that becomes the "
            "labelled recording. With --net a network labels the images of INPUT/rgb.",
            "xview label scan.pcd labelled.pcd && pcl_viewer labelled.pcd",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--net", model_, "a segmentation network that labels rgb images, such as an .onnx");
    flags.add("--net-config", net_config_,
              "YAML of its label set, ids of its classes, width, height, mean, std, order of "
              "colours; see config/networks/");
    flags.add("--voxel", voxel_m_,
              "thin the cloud to one point per voxel and class; 0 = keep all [m]");
  }

  ExitCode run(const Job& job) override {
    if (!(voxel_m_ >= 0)) throw UsageError(fmt::format("--voxel {}, must be >= 0", voxel_m_));
    const std::string& out = job.operands[1];
    if (isCloudFilePath(out)) requireCloudPath(out);
    Stopwatch watch;
    const auto source = openLabelled(job);
    if (isCloudFilePath(out)) {
      writeCloud(out, liftAll(*source, job, voxel_m_), source->labels());
    } else {
      io::writeRecording(out, *source, {}, job.options.threads, job.narrate.progress("label"));
    }
    job.narrate.stage("label", watch.lap_ms(), fmt::format("{} frames: {}", source->size(), out));
    return kDone;
  }

 private:
  std::unique_ptr<FrameSource> openLabelled(const Job& job) const {
    io::InputOptions options = input_.parsed();
    if (model_.empty() != net_config_.empty())
      throw UsageError("--net and --net-config belong together");
    if (!model_.empty()) {
      return labelledByNetwork(io::openRecording(job.operands[0], options), model_,
                               io::readNetworkInput(net_config_));
    }
    options.labels = kShapes;
    return openInput(job.operands[0], options, job);
  }

  InputFlags input_;
  std::string model_, net_config_;
  double voxel_m_ = 0;
};

}  // namespace

std::unique_ptr<Command> makeLabel() { return std::make_unique<LabelCommand>(); }

}  // namespace xview::tools
