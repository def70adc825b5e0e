// SPDX-License-Identifier: BSD-3-Clause
#include "tool.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

/// Stands in for the simulator in builds without Embree.
class SimulateCommand final : public Command {
 public:
  Description describe() const override {
    return {"simulate", "OUT_DIR", "a seeded world and its recordings (not in this build)",
            "The simulator needs Embree: install libembree-dev and build again.",
            "xview simulate town --seed 7"};
  }
  void declare(Flags&) override {}
  ExitCode run(const Job&) override {
    throw Error(
        "this build has no simulator: Embree was not found; install libembree-dev and build again");
  }
};

}  // namespace

std::unique_ptr<Command> makeSimulate() { return std::make_unique<SimulateCommand>(); }

}  // namespace xview::tools
