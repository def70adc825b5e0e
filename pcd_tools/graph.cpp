// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/graph.h"

#include <fmt/core.h>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/io/graph_files.h"
#include "xview/types/atomic_file.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

class GraphCommand final : public Command {
 public:
  Description describe() const override {
    return {"graph",
            "INPUT GRAPH.ply",
            "blobs, merged over frames, with edges",
            "INPUT may also be a map, whose graph is written, or a graph without edges, which gets "
            "them.",
            "xview graph town/forward town.ply --edges.radius_m 15",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& job) override {
    const std::string& out = job.operands[1];
    if (endingOf(out) != ".ply") throw UsageError(out + ": a graph ends with .ply");
    requireWritable(out);
    const Place result = read(job);
    io::writeGraph(out, result.graph, result.labels);
    fmt::print("{} vertices, {} edges, {} connected parts\n", result.graph.size(),
               result.graph.edgeCount(), componentCount(result.graph));
    return kDone;
  }

 private:
  Place read(const Job& job) const {
    const std::string& path = job.operands[0];
    io::InputOptions input = input_.parsed();
    if (auto stored = readStored(path, input, job)) return std::move(*stored);
    const auto source = openInput(path, input, job);
    FrameReport report(*source, job.narrate);
    Place place =
        makeQuery(*source, job.options, [&](const FrameDigest& frame) { report.add(frame); });
    report.say();
    if (place.graph.empty()) {
      throw Error(path,
                  fmt::format("no blobs in {} frames: nothing to make a graph of", report.added()));
    }
    return place;
  }

  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeGraph() { return std::make_unique<GraphCommand>(); }

}  // namespace xview::tools
