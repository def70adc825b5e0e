// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include "process/atomic_file.h"
#include "tool.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

/// What a user would type, and what is said before it.
struct Step {
  std::string says;
  std::vector<std::string> arguments;
  bool must_accept = true;  ///< else it is right that nothing is accepted
};

/// A town of its own streets, two drives to map and to find, one flight, and a drive through
/// another town.
std::vector<Step> stepsIn(const std::string& folder) {
  const auto in = [&](const std::string& name) { return folder + "/" + name; };
  const std::string town = in("town"), map = in("town.xvm"), elsewhere = in("elsewhere.jsonl");
  std::vector<Step> steps = {
      {"simulating a town (camera forward, rear, from the air; and another town) into " + town,
       {"simulate", town, "--seed", "7", "--sessions.elsewhere"}},
      {"mapping the forward drive into " + map, {"map", town + "/forward", map}},
      {"", {"view", map, "-o", in("map.png"), "--quiet"}},
      {"where was the rear camera?", {"localize", town + "/rear", map, "--frames", "0:60"}},
      {"another town must be refused",
       {"localize", town + "/elsewhere", map, "--window", "60", "--stride", "30", "-o", elsewhere},
       false},
      {"", {"view", map, elsewhere, "-o", in("elsewhere.png"), "--quiet"}}};
  for (const std::string session : {"rear", "aerial"}) {
    const std::string query = town + "/" + session, answers = in(session + ".jsonl");
    steps.push_back({"finding the " + session + " view, windows of 30 frames, in that map",
                     {"localize", query, map, "--window", "30", "-o", answers}});
    steps.push_back({"",
                     {"evaluate", answers, query + "/groundtruth.txt", "--negatives", elsewhere,
                      "-o", in("report_" + session), "--quiet"}});
    steps.push_back({"", {"view", map, answers, "-o", in(session + ".png"), "--quiet"}});
    steps.push_back(
        {"",
         {"match", query, map, in("match_" + session + ".png"), "--frames", "0:60", "--quiet"}});
  }
  return steps;
}

class DemoCommand final : public Command {
 public:
  Description describe() const override {
    return {"demo",
            "[DIR]",
            "a town, its map and three queries, in a minute",
            "Simulates a town and another one, maps a drive, and looks for a drive back, for a "
            "flight and for the other town in that map, into DIR (default xview_demo). Every "
            "command is printed before it runs.",
            "xview demo",
            0,
            1};
  }

  void declare(Flags&) override {}

  ExitCode run(const Job& job) override {
    const std::string folder = job.operands.empty() ? "xview_demo" : job.operands[0];
    makeFolder(folder);
    for (const Step& step : stepsIn(folder)) {
      if (!step.says.empty()) job.narrate.summary("== " + step.says);
      std::vector<std::string> arguments = step.arguments;
      if (job.narrate.isQuiet()) arguments.push_back("--quiet");
      job.narrate.line(commandLine(step.arguments));
      const int code = runProgram(arguments);
      const int expected = step.must_accept ? kDone : kNoPose;
      if (code == expected) continue;
      throw Error(commandLine(step.arguments),
                  fmt::format("ended with {}, expected {}", code, expected));
    }
    job.narrate.summary(fmt::format(
        "Open {}/report_rear/report.html in a browser: the map, every answer in it and its "
        "error. Pictures: rear.png, aerial.png (found), elsewhere.png (refused), match_*.png",
        folder));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> makeDemo() { return std::make_unique<DemoCommand>(); }

}  // namespace xview::tools
