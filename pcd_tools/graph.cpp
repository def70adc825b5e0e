// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/graph.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cstring>

#include "base/user_text.h"
#include "inputs.h"
#include "io/graph_files.h"
#include "outputs.h"
#include "place/edges.h"
#include "process/atomic_file.h"
#include "tool.h"
#include "view/scene.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

/// http://graphml.graphdrawing.org: what networkx, igraph and Gephi read.
std::string toGraphml(const SemanticGraph& graph, const LabelSet& labels) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n";
  for (const char* key : {"class:string", "label:int", "x:double", "y:double", "z:double",
                          "sigma_m:double", "observations:int", "points:int"}) {
    const std::string name(key, std::strchr(key, ':'));
    text += fmt::format("<key id=\"{0}\" for=\"node\" attr.name=\"{0}\" attr.type=\"{1}\"/>\n",
                        name, std::strchr(key, ':') + 1);
  }
  text += "<graph edgedefault=\"undirected\">\n";
  const auto data = [&](const char* key, const auto& value) {
    text += fmt::format("<data key=\"{}\">{}</data>", key, value);
  };
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Vertex& v = graph.vertices[i];
    text += fmt::format("<node id=\"{}\">", i);
    data("class", xmlText(printable(labels.className(v.label))));
    data("label", v.label);
    data("x", v.position.x());
    data("y", v.position.y());
    data("z", v.position.z());
    data("sigma_m", v.sigma_m);
    data("observations", v.observations);
    data("points", v.points);
    text += "</node>\n";
  }
  for (const auto& [a, b] : graph.edges())
    text += fmt::format("<edge source=\"{}\" target=\"{}\"/>\n", a, b);
  return text + "</graph>\n</graphml>\n";
}

/// One line per vertex, the neighbours separated by blanks.
std::string toCsv(const SemanticGraph& graph, const LabelSet& labels) {
  std::string text =
      "vertex,class,label,x,y,z,size_x,size_y,size_z,sigma_m,observations,points,neighbours\n";
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Vertex& v = graph.vertices[i];
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", i,
                        csvQuoted(labels.className(v.label)), v.label, v.position.x(),
                        v.position.y(), v.position.z(), v.extent.x(), v.extent.y(), v.extent.z(),
                        v.sigma_m, v.observations, v.points, fmt::join(graph.neighbours[i], " "));
  }
  return text;
}

class GraphCommand final : public Command {
 public:
  Description describe() const override {
    return {"graph",
            "INPUT GRAPH.ply",
            "blobs, merged over frames, with edges",
            "INPUT may also be a map, whose graph is written, or a graph without edges, which gets "
            "them. GRAPH.graphml is for networkx, igraph and Gephi, GRAPH.csv a table of vertices.",
            "xview graph town/forward town.ply --edges.radius_m 15",
            2,
            2,
            true};
  }

  void declare(Flags& flags) override { input_.declare(flags); }

  ExitCode run(const Job& job) override {
    const std::string& out = job.operands[1];
    const std::string ending = endingOf(out);
    if (ending != ".ply" && ending != ".graphml" && ending != ".csv")
      throw UsageError(out + ": a graph ends with .ply, .graphml or .csv");
    requireWritable(out);
    Place result = read(job);
    makeEdges(result.graph);
    if (ending == ".ply")
      io::writeGraph(out, result.graph, result.labels);
    else
      writeFile(out, ending == ".csv" ? toCsv(result.graph, result.labels)
                                      : toGraphml(result.graph, result.labels));
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
        makeQuery(*source, job.options, [&](const PreprocessedFrame& frame) { report.add(frame); });
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
