// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include "process/module.h"
#include "server.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

class ServeCommand final : public Command {
 public:
  Description describe() const override {
    return {"serve",
            "MAP",
            "the map in memory behind a socket: where is what is posted?",
            "POST /localize takes a cloud file and answers the JSON of localize; POST /track/ID a "
            "frame, with its odometry in the header X-Pose, and answers a line of follow; DELETE "
            "/track/ID forgets it. GET "
            "/health, /metrics (Prometheus), /openapi.json. A MAP file that changes is loaded and "
            "exchanged between two requests. SIGINT and SIGTERM end it (130, 143) once all "
            "requests are answered, or --patience is over.",
            "xview serve town.xvm --socket /run/xview/town.sock",
            1,
            1};
  }

  void declare(Flags& flags) override {
    serving_.input.declareWithMap(flags);
    flags.add("--socket PATH", serving_.where.socket,
              "listen on this Unix socket, which is its owner's only");
    flags.add("--socket-mode MODE", serving_.where.mode,
              "of that socket, octal: 0660 for its group, too");
    flags.add("--socket-group GROUP", serving_.where.group,
              "of that socket, whose mode then is 0660");
    flags.add("--port", serving_.where.port,
              "listen on this port, if there is no --socket; 0 = any free one");
    flags.add("--listen ADDRESS", serving_.where.address,
              "of the port; beyond this machine only if asked");
    flags.add("--max-body", serving_.max_body_mb, "largest body [MB]; larger: 413");
    flags.add("--max-clients", serving_.where.max_clients, "connections at a time; more: 503");
    flags.add("--jobs", serving_.jobs, "queries computed at a time; the others wait");
    verdict_.declare(flags);
    flags.add("--patience", serving_.where.patience_s,
              "a request must come within this time, else 408, and have its turn within it, else "
              "503 [s]");
  }

  ExitCode run(const Job& given) override {
    checkFlags();
    Job job = given;
    verdict_.applyTo(job);
    reinterpret_cast<decltype(&xviewServe)>(
        moduleFunction("xview_serve", "xviewServe", "xview serve"))(serving_, job);
    return kDone;
  }

 private:
  static void requirePositive(const char* name, int value) {
    if (value < 1) throw UsageError(fmt::format("{} = {}, must be >= 1", name, value));
  }

  void checkFlags() const {
    if (serving_.where.port < 0 || serving_.where.port > 65535)
      throw UsageError(fmt::format("--port = {}, must be in [0, 65535]", serving_.where.port));
    requirePositive("--max-body", serving_.max_body_mb);
    requirePositive("--max-clients", serving_.where.max_clients);
    requirePositive("--jobs", serving_.jobs);
    if (!(serving_.where.patience_s > 0 && serving_.where.patience_s < 1e6))
      throw UsageError(fmt::format("--patience = {}, must be > 0", serving_.where.patience_s));
  }

  Serving serving_;
  VerdictFlags verdict_;
};

}  // namespace

std::unique_ptr<Command> makeServe() { return std::make_unique<ServeCommand>(); }

}  // namespace xview::tools
