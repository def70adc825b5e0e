// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/graph.h"

#include <fmt/core.h>

#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/io/graph_files.h"
#include "xview/map/semantic_map.h"
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
    const LabelledGraph result = read(job);
    io::writeGraph(out, result.graph, result.labels);
    fmt::print("{} vertices, {} edges, {} connected parts\n", result.graph.size(),
               result.graph.edgeCount(), componentCount(result.graph));
    return kDone;
  }

 private:
  LabelledGraph read(const Job& job) const {
    const std::string& path = job.operands[0];
    io::InputOptions input = input_.parsed();
    switch (settleKind(path, input, job)) {
      case io::InputKind::map: {
        map::SemanticMap map = map::loadMap(path);
        return {std::move(map.labels), std::move(map.graph)};
      }
      case io::InputKind::graph:
        return readLabelledGraph(path, input, job);
      default:
        return assemble(path, input, job);
    }
  }

  LabelledGraph assemble(const std::string& path, const io::InputOptions& input,
                         const Job& job) const {
    const auto source = openInput(path, input, job);
    FrameReport report(*source, job.narrate);
    SemanticGraph graph =
        makeQuery(*source, job.options, [&](const FrameDigest& frame) { report.add(frame); }).graph;
    report.say();
    if (graph.empty()) {
      throw Error(path,
                  fmt::format("no blobs in {} frames: nothing to make a graph of", report.added()));
    }
    return {source->labels(), std::move(graph)};
  }

  InputFlags input_;
};

}  // namespace

std::unique_ptr<Command> makeGraph() { return std::make_unique<GraphCommand>(); }

}  // namespace xview::tools
