// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "answer.h"
#include "compare/likelihood_learning.h"
#include "consistency_checks.h"
#include "inputs.h"
#include "process/atomic_file.h"
#include "tool.h"
#include "verdict/verdict.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/io/pose_files.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {
namespace {

class LearnCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "learn",
        "RECORDING... MAP OUT.txt",
        "learn the likelihoods of the place search, or the verdict, from known poses",
        "Counts how far what a RECORDING saw lies from the same class in the MAP, at its true "
        "poses and at wrong ones.\n"
        "True poses (sensor in the map frame, TUM or KITTI) are in groundtruth.txt or "
        "truth.txt of the RECORDING. The\n"
        "map must be of another drive. Use the result with --places.likelihoods OUT.txt.\n"
        "--verdict RESULTS.jsonl... OUT.txt fits the confidence to answers of xview localize "
        "--json about recordings "
        "with such a file, or\n"
        "graphs with GRAPH.truth.txt (T_map_query), and out-of-map ones; an answer may say itself "
        "whether it is \"right\", and of which\n"
        "\"make\" its world and sensor are: weights are judged on makes that did not set them. "
        "Use the result with --verdict.model OUT.txt.",
        "xview learn town/rear town/aerial town.xvm town.txt",
        2,
        100000,
        true};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--verdict", verdict_, "learn from the answers in RESULTS.jsonl how sure to be");
    flags.add("--right", right_m_, "an answer this near to the truth is right [m]");
    flags.add("--wrong", wrong_m_,
              "one farther than this is wrong; between them it is left out [m]");
    flags.add("--truth", truth_, "file with the true poses, if there is one RECORDING");
    flags.add("--length", length_m_, "travel per query, as queries will have it [m]");
    flags.add("--add", add_, "start with the counts of this file");
    flags.add("--add-default", add_default_, "start with the counts that the program comes with");
  }

  ExitCode run(const Job& job) override {
    if (verdict_) return learnVerdict(job);
    if (job.operands.size() < 3) throw UsageError("the operands are RECORDING... MAP OUT.txt");
    if (!(length_m_ > 0)) throw UsageError(fmt::format("--length = {}, must be > 0", length_m_));
    if (!truth_.empty() && job.operands.size() != 3)
      throw UsageError("--truth is for one RECORDING; put groundtruth.txt into their folders");
    if (map::isMapFile(job.operands.back())) {
      throw UsageError(job.operands.back() +
                       " is a map: the operands are RECORDING... MAP OUT.txt, OUT.txt comes last");
    }
    AtomicFile out(job.operands.back());
    const map::SemanticMap map = readWholeMap(job.operands[job.operands.size() - 2], input_, job);
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
  ExitCode learnVerdict(const Job& job) const {
    AtomicFile out(job.operands.back());
    Truths truths;
    std::vector<verdict::JudgedStatistics> judged;
    std::map<std::string, std::size_t> makes;
    for (std::size_t i = 0; i + 1 < job.operands.size(); ++i) {
      for (const Answer& answer : readAnswers(job.operands[i])) {
        if (answer.fix.hypotheses.empty()) continue;
        if (!answer.whole_statistics)
          throw Error(job.operands[i],
                      "its answers lack some of what a verdict is made of, as those of older "
                      "programs do; localize again");
        const double error_m =
            answer.right ? (*answer.right ? 0 : INFINITY) : truths.errorOf(answer);
        if (error_m > right_m_ && error_m <= wrong_m_) continue;
        const std::string& make = answer.make.empty() ? job.operands[i] : answer.make;
        const std::size_t group = makes.try_emplace(make, makes.size()).first->second;
        judged.push_back({answer.fix.statistics, error_m <= right_m_, group});
      }
    }
    const auto rights = std::count_if(judged.begin(), judged.end(),
                                      [](const verdict::JudgedStatistics& j) { return j.right; });
    out.write(verdict::toText(verdict::fitVerdictModel(judged)));
    out.commit();
    fmt::print("{}: {} right and {} wrong answers\n", job.operands.back(), rights,
               static_cast<std::ptrdiff_t>(judged.size()) - rights);
    if (makes.size() > 1) printLeftOut(judged, makes);
    return kDone;
  }

  /// What would be accepted of each make by a model that the others set, as a table.
  static void printLeftOut(const std::vector<verdict::JudgedStatistics>& judged,
                           const std::map<std::string, std::size_t>& makes) {
    fmt::print(
        "\nEach make judged by what the others set, right ones accepted and wrong ones accepted at "
        "a risk of:\n\n"
        "| make | right | 0.1 | 0.01 | 0.001 | wrong | 0.1 | 0.01 | 0.001 |\n"
        "|---|---|---|---|---|---|---|---|---|\n");
    LeftOut all;
    for (const auto& [make, group] : makes) {
      std::vector<verdict::JudgedStatistics> here, others;
      for (const verdict::JudgedStatistics& j : judged)
        (j.group == group ? here : others).push_back(j);
      const verdict::VerdictModel model = verdict::fitVerdictModel(others);
      LeftOut of_make;
      for (const verdict::JudgedStatistics& j : here) {
        const double confidence = verdict::confidenceOf(j.statistics, model);
        of_make.add(j.right, confidence);
        all.add(j.right, confidence);
      }
      of_make.print(make);
    }
    all.print("all");
  }

  /// Answers that are right and wrong, and how many of each are accepted by the risk.
  struct LeftOut {
    static constexpr std::array kRisks{0.1, 0.01, 0.001};
    std::array<int, 2> answers{};
    std::array<std::array<int, kRisks.size()>, 2> accepted{};

    void add(bool right, double confidence) {
      ++answers[right];
      for (std::size_t i = 0; i < kRisks.size(); ++i)
        accepted[right][i] += confidence >= 1 - kRisks[i];
    }
    void print(const std::string& name) const {
      fmt::print("| {} | {} | {} | {} | {} |\n", name, answers[1], fmt::join(accepted[1], " | "),
                 answers[0], fmt::join(accepted[0], " | "));
    }
  };

  /// The true poses of recordings, each file read once.
  class Truths {
   public:
    /// Infinite for a recording without true poses, which is out of the map.
    double errorOf(const Answer& answer) {
      const std::string file = truthBeside(answer.input);
      if (file.empty()) return INFINITY;
      const Truth& truth = read_.try_emplace(file, file).first->second;
      const Eigen::Isometry3d& found = std::filesystem::is_directory(answer.input)
                                           ? answer.fix.T_map_sensor
                                           : answer.fix.T_map_query;
      return (truth.poseFor(answer).translation() - found.translation()).norm();
    }

   private:
    std::map<std::string, Truth> read_;
  };

  /// Of a graph the true T_map_query in GRAPH.truth.txt. Empty if there is none.
  static std::string truthBeside(const std::string& recording) {
    const std::filesystem::path graph(recording);
    if (const std::string file = std::filesystem::path(graph).replace_extension(".truth.txt");
        !std::filesystem::is_directory(graph) && std::filesystem::exists(file))
      return file;
    for (const char* name : {"/groundtruth.txt", "/truth.txt"}) {
      if (std::filesystem::exists(recording + name)) return recording + name;
    }
    return {};
  }

  search::LikelihoodTable learnFrom(const std::string& path, const map::SemanticMap& map,
                                    const Job& job) const {
    const auto recording = openPlaceInput(path, inputIn(input_, map.labels), job);
    std::vector<PreprocessedFrame> frames;
    std::vector<std::int64_t> numbers;
    FrameReport report(*recording, job.narrate);
    preprocessRecording(*recording, job.options, [&](PreprocessedFrame frame) {
      report.add(frame);
      numbers.push_back(frame.number);
      frames.push_back(std::move(frame));
    });
    report.say();
    std::vector<Eigen::Isometry3d> truth;
    for (const io::StampedPose& pose : io::posesOfFrames(truthFileOf(path), numbers))
      truth.push_back(pose.T_frame_sensor);
    constexpr double kExact_m = 1e-3;  // which no second drive repeats
    if (areSamePoses(map.poses, truth, kExact_m)) {
      throw Error(
          path,
          "is the drive that the map was made of, which finds itself without any error; learn "
          "from another drive of the same place");
    }
    Stopwatch watch;
    const search::LikelihoodTable table =
        learnLikelihoods(map, frames, truth, length_m_, job.options);
    job.narrate.stage("learn", watch.lap_ms(), path);
    return table;
  }

  std::string truthFileOf(const std::string& recording) const {
    if (!truth_.empty()) return truth_;
    if (std::string file = truthBeside(recording); !file.empty()) return file;
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
  bool verdict_ = false;
  double right_m_ = 1, wrong_m_ = 5;
  std::string truth_, add_;
  double length_m_ = 60;
  bool add_default_ = false;
};

}  // namespace

std::unique_ptr<Command> makeLearn() { return std::make_unique<LearnCommand>(); }

}  // namespace xview::tools
