// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <set>

#include "base/user_text.h"
#include "inputs.h"
#include "outputs.h"
#include "process/atomic_file.h"
#include "scenes.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/localizer.h"

namespace xview::tools {
namespace {

/// What was tried, a line per pair: the query's vertex in its odometry frame, the map's in that of
/// the map.
std::string toCsv(const Localization& fix, const Query& query, const map::SemanticMap& map) {
  std::string text = "kept,similarity,class,query_vertex,x,y,z,map_vertex,map_x,map_y,map_z\n";
  std::set<std::pair<std::uint32_t, std::uint32_t>> kept;
  for (const Correspondence& c : fix.kept) kept.insert({c.query, c.map});
  for (const Correspondence& c : fix.putative) {
    const Vertex &a = query.graph.vertices[c.query], &b = map.graph.vertices[c.map];
    text += fmt::format("{},{:.4f},{},{},{:.3f},{:.3f},{:.3f},{},{:.3f},{:.3f},{:.3f}\n",
                        kept.count({c.query, c.map}), c.similarity,
                        csvQuoted(map.labels.className(b.label)), c.query, a.position.x(),
                        a.position.y(), a.position.z(), c.map, b.position.x(), b.position.y(),
                        b.position.z());
  }
  return text;
}

class MatchCommand final : public Command {
 public:
  Description describe() const override {
    return {"match",
            "QUERY MAP OUT.ply",
            "putative and kept correspondences, coloured",
            "The map lies below, the query above it at the pose that was found; green lines were "
            "kept, pale red ones only tried. OUT.ply or OUT.vtk is a mesh for MeshLab or "
            "pcl_viewer, OUT.pcd a cloud, OUT.png or OUT.svg a picture, OUT.html a page to turn, "
            "OUT.csv a table of the pairs. It is written for the best pose that was found, whether "
            "accepted (exit code 0) or not (3).",
            "xview match town/rear town.xvm match.ply --frames 0:60",
            3,
            3,
            true};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    verdict_.declare(flags);
  }

  ExitCode run(const Job& given) override {
    Job job = given;
    verdict_.applyTo(job);
    const std::string& out = job.operands[2];
    requireDrawingPath(out, true);
    if (!job.options.scale.empty())
      throw UsageError("--scale: match draws the query in its own lengths");
    checkOrder({job.operands[0], job.operands[1]}, input_);
    const map::SemanticMap map = readWholeMap(job.operands[1], input_, job);
    const Job sized = inMap(job, map);
    const Budget budget(job.limits);
    const QueryInput input = readQuery(job.operands[0], input_, sized, map.labels);
    const Query& query = *input.whole;
    Stopwatch watch;
    const Localizer localizer(map::borrowed(map), sized.options, input.options.class_names);
    const Localization fix = localizer.localize(query);
    job.narrate.stage("match", watch.lap_ms(),
                      fmt::format("{}: {}", toString(fix.status), fix.reason));

    Scene scene = sceneOf(map);
    scene.queries.push_back(queryWith(query, fix));
    scene.queries[0].name = job.operands[0];
    scene.title = outcomeOf(scene.queries);
    scene.caption = fmt::format("{} in {}: {}", job.operands[0], job.operands[1], fix.reason);
    scene.made_by = madeBy(job);
    scene.facts = {
        {"kept correspondences", fmt::format("{} of {}", fix.kept.size(), fix.putative.size())},
        {"query vertices", fmt::format("{}", query.graph.size())},
        {"map vertices", fmt::format("{}", map.graph.size())}};
    if (endingOf(out) == ".csv")
      writeFile(out, toCsv(fix, query, map));
    else
      writeDrawing(out, scene, job.narrate);
    fmt::print("{} query vertices, {} map vertices, {} putative correspondences, {} kept, {}\n",
               query.graph.size(), map.graph.size(), fix.putative.size(), fix.kept.size(),
               toString(fix.status));
    return fix.accepted() ? kDone : kNoPose;
  }

 private:
  InputFlags input_;
  VerdictFlags verdict_;
};

}  // namespace

std::unique_ptr<Command> makeMatch() { return std::make_unique<MatchCommand>(); }

}  // namespace xview::tools
