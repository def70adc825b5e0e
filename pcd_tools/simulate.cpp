// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "base/option_field.h"
#include "outputs.h"
#include "sim/recordings.h"
#include "tool.h"
#include "xview/base/localization.h"
#include "xview/io/recording.h"

namespace xview::tools {
namespace {

class SimulateCommand final : public Command {
 public:
  Description describe() const override {
    return {"simulate",
            "OUT_DIR",
            "a seeded world and its recordings (sequence folders, LiDAR scans, truth)",
            "Each session becomes a folder: forward (whose odometry frame is the map frame) and "
            "the chosen ones. --sim.style suburb|grid|village|campus|office says what kind "
            "of world. groundtruth.txt holds the true poses in the map frame. Switch a session "
            "with --sessions.rear=false.",
            "xview simulate town --seed 7 --quality noisy --sessions.elsewhere",
            1,
            1,
            true};
  }

  /// A flag for every option of the simulator but seed and threads, which are common flags.
  void declare(Flags& flags) override {
    for (const OptionField& field : fieldsOf(options_)) {
      if (field.key == "seed" || field.key == "threads") continue;
      const std::size_t dot = field.key.find('.');
      const bool is_rare = dot != std::string::npos && field.key.substr(0, dot) != "sessions";
      const Flags group = is_rare ? flags.rare() : flags;
      const char* what = std::holds_alternative<std::string*>(field.value) ? " WORD" : "";
      std::visit([&](auto* value) { group.add("--" + field.key + what, *value, field.meaning); },
                 field.value);
    }
  }

  ExitCode run(const Job& job) override {
    options_.seed = job.options.seed;
    options_.threads = job.options.threads;
    Stopwatch watch;
    std::vector<ObjectChange> changes;
    const auto sessions = makeSessions(options_, &changes);
    job.narrate.stage("town", watch.lap_ms(), fmt::format("{} sessions", sessions.size()));
    const std::string& out = job.operands[0];
    std::optional<AtomicFolder> world;  // that appears with all its sessions
    if (!std::filesystem::exists(out)) world.emplace(out);
    const std::string folder = world ? world->temporaryPath() : out;
    for (const auto& session : sessions) {
      std::vector<Eigen::Isometry3d> truth;
      for (std::size_t i = 0; i < session->size(); ++i) truth.push_back(session->truth(i));
      io::writeRecording(folder + "/" + session->name(), *session, truth, job.options.threads,
                         job.narrate.progress(session->name()));
      job.narrate.stage("render", watch.lap_ms(),
                        fmt::format("{}/{}: {} frames", out, session->name(), session->size()));
    }
    const std::string table = folder + "/changes.csv";
    if (changes.empty())
      std::filesystem::remove(table);  // of another world that was there
    else
      writeFile(table, toCsv(changes));
    if (world) world->commit();
    for (const auto& session : sessions) fmt::print("{}/{}\n", out, session->name());
    return kDone;
  }

 private:
  /// Where a thing stood or stands, and to where it was moved; map frame.
  static std::string toCsv(const std::vector<ObjectChange>& changes) {
    constexpr const char* kNames[] = {"gone", "new", "moved"};
    std::string text = "change,class,x,y,z,to_x,to_y,to_z\n";
    for (const ObjectChange& c : changes) {
      text += fmt::format("{},{},{:.3f},{:.3f},{:.3f},", kNames[static_cast<int>(c.what)],
                          c.class_name, c.foot.x(), c.foot.y(), c.foot.z());
      text += c.what == ObjectChange::What::moved
                  ? fmt::format("{:.3f},{:.3f},{:.3f}\n", c.later.x(), c.later.y(), c.later.z())
                  : std::string(",,\n");
    }
    return text;
  }

  SimulationOptions options_;
};

}  // namespace

std::unique_ptr<Command> makeSimulate() { return std::make_unique<SimulateCommand>(); }

}  // namespace xview::tools
