// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>

#include "inputs.h"
#include "tool.h"
#include "xview/io/atomic_file.h"
#include "xview/io/pose_files.h"
#include "xview/likelihood_learning.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

class LearnCommand final : public Command {
 public:
  Description describe() const override {
    return {"learn",
            "RECORDING... MAP OUT.txt",
            "learn the likelihoods of the place search from recordings with known poses",
            "Counts how far what a RECORDING saw lies from the same class in the MAP, at its true "
            "poses and at wrong ones.\n"
            "True poses (sensor in the map frame, TUM or KITTI) are in groundtruth.txt or "
            "truth.txt of the RECORDING. The\n"
            "map must be of another drive. Use the result with --places.likelihoods OUT.txt.",
            "xview learn town/rear town/aerial town.xvm town.txt",
            3,
            100000};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--truth", truth_, "file with the true poses, if there is one RECORDING");
    flags.add("--length", length_m_, "travel per query, as queries will have it [m]");
    flags.add("--add", add_, "start with the counts of this file");
    flags.add("--add-default", add_default_, "start with the counts that the program comes with");
  }

  ExitCode run(const Job& job) override {
    if (!(length_m_ > 0)) throw UsageError(fmt::format("--length = {}, must be > 0", length_m_));
    if (!truth_.empty() && job.operands.size() != 3)
      throw UsageError("--truth is for one RECORDING; put groundtruth.txt into their folders");
    if (map::isMapFile(job.operands.back())) {
      throw UsageError(job.operands.back() +
                       " is a map: the operands are RECORDING... MAP OUT.txt, OUT.txt comes last");
    }
    io::AtomicFile out(job.operands.back());
    const map::SemanticMap map = readMap(job.operands[job.operands.size() - 2], input_, job);
    const Job sized = inMap(job, map);
    search::LikelihoodTable learned;
    for (std::size_t i = 0; i + 2 < job.operands.size(); ++i)
      learned.add(learnFrom(job.operands[i], map, sized));
    const double samples = samplesAtTruth(learned);
    if (samples == 0) {
      throw Error(job.operands[0], fmt::format("nothing learned: no travel of {} m of it sees "
                                               "anything of a class that the map holds",
                                               length_m_));
    }
    if (add_default_) learned.add(search::defaultLikelihoods());
    if (!add_.empty()) learned.add(search::readLikelihoods(add_));
    out.write(search::toText(learned));
    out.commit();
    fmt::print("{}: {:.0f} samples at true poses\n", job.operands.back(), samples);
    return kDone;
  }

 private:
  search::LikelihoodTable learnFrom(const std::string& path, const map::SemanticMap& map,
                                    const Job& job) const {
    const auto recording = openInput(path, input_.parsed(), job);
    std::vector<FrameDigest> frames;
    std::vector<std::int64_t> numbers;
    FrameReport report(recording->name(), recording->size(), job.narrate);
    digestRecording(*recording, job.options, [&](FrameDigest frame) {
      report.add(frame);
      numbers.push_back(frame.number);
      frames.push_back(std::move(frame));
    });
    report.say();
    std::vector<Eigen::Isometry3d> truth;
    for (const io::StampedPose& pose : io::posesOfFrames(truthFileOf(path), numbers))
      truth.push_back(pose.T_frame_sensor);
    Stopwatch watch;
    const search::LikelihoodTable table =
        learnLikelihoods(map, frames, truth, length_m_, job.options);
    job.narrate.stage("learn", watch.lap_ms(), path);
    return table;
  }

  std::string truthFileOf(const std::string& recording) const {
    if (!truth_.empty()) return truth_;
    for (const char* name : {"/groundtruth.txt", "/truth.txt"}) {
      if (std::filesystem::exists(recording + name)) return recording + name;
    }
    throw Error(recording,
                "expected groundtruth.txt or truth.txt with the poses in the map frame, found "
                "neither; --truth names another file");
  }

  static double samplesAtTruth(const search::LikelihoodTable& table) {
    double sum = 0;
    for (const auto& viewpoint : table.counts) {
      for (const search::DistanceCounts& channel : viewpoint) {
        for (const double n : channel.at_true) sum += n;
      }
    }
    return sum;
  }

  InputFlags input_;
  std::string truth_, add_;
  double length_m_ = 60;
  bool add_default_ = false;
};

}  // namespace

std::unique_ptr<Command> makeLearn() { return std::make_unique<LearnCommand>(); }

}  // namespace xview::tools
