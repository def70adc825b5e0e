// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "answer_file.h"
#include "commands.h"
#include "drawing.h"
#include "drawn_answers.h"
#include "frames_to_cloud.h"
#include "inputs.h"
#include "xview/graph/blobs.h"
#include "xview/io/atomic_file.h"
#include "xview/map/map_store.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

void append(SemanticGraph& graph, const SemanticGraph& part) {
  const auto shift = static_cast<std::uint32_t>(graph.size());
  auto edges = graph.edges();
  for (const auto& [a, b] : part.edges()) edges.emplace_back(a + shift, b + shift);
  graph.vertices.insert(graph.vertices.end(), part.vertices.begin(), part.vertices.end());
  graph.setEdges(edges);
}

/// Everything that is shown together, in one frame.
struct Content {
  LabelSet labels;
  SemanticGraph graph;
  LabelledCloud cloud;
  PlanView plan;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<SceneQuery> queries;

  void addLabels(const LabelSet& more) {
    for (const auto& [id, info] : more.classes()) {
      if (!labels.find(id)) labels.add(info);
    }
  }
};

class ViewCommand final : public Command {
 public:
  Description describe() const override {
    return {"view",
            "FILE... [OUT]",
            "a picture, page, mesh or cloud of maps, recordings, graphs, clouds and answers",
            "FILEs share one frame; answers of localize --json (.jsonl) are drawn into the map "
            "before them, with the\n"
            "way, cloud or graph of the query if it is still where it was. OUT ends with\n"
            ".png, .html, .vtk, .ply or .pcd; a .ply or .pcd that exists is a FILE unless it is "
            "given by -o. Without OUT a\n"
            ".png is written beside the first FILE.",
            "xview view town.xvm rear.jsonl town.png",
            1,
            1000};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("-o,--out", out_, "the file to write, if not the last operand");
    flags.add("--voxel", voxel_m_, "thin recordings to one point per voxel and class [m]");
  }

  ExitCode run(const Job& job) override {
    std::vector<std::string> files = job.operands;
    const std::string out = takeOut(files);
    checkDrawingEnding(out);
    requireWritable(out);
    Stopwatch watch;
    Content content;
    DrawnAnswers drawn(input_, voxel_m_, job);
    for (const std::string& file : files) {
      if (fs::path(file).extension() == ".jsonl")
        addAnswers(file, drawn, content);
      else
        add(file, job, content);
    }
    job.narrate.stage("read", watch.lap_ms(),
                      fmt::format("{} vertices, {} points, {} queries", content.graph.size(),
                                  content.cloud.size(), content.queries.size()));
    Scene scene = sceneOf(content, files);
    scene.lines = drawn.outlines();
    writeDrawing(out, scene);
    job.narrate.stage("view", watch.lap_ms(), out);
    fmt::print("{}\n", out);
    return kDone;
  }

 private:
  /// The output, removed from the operands if it was the last of them.
  std::string takeOut(std::vector<std::string>& files) const {
    if (!out_.empty()) return out_;
    const std::string last = files.back();
    const std::string ending = fs::path(last).extension().string();
    const bool may_be_input = ending == ".ply" || ending == ".pcd";
    if (files.size() > 1 && isDrawing(last) && !(may_be_input && fs::exists(last))) {
      files.pop_back();
      return last;
    }
    fs::path beside = fs::path(files[0]).lexically_normal();
    if (!beside.has_filename()) beside = beside.parent_path();  // "town/"
    return beside.replace_extension(".png").string();
  }

  void add(const std::string& path, const Job& job, Content& content) const {
    switch (recogniseInput(path, input_.parsed())) {
      case InputKind::map:
        return addMap(loadMap(path), content);
      case InputKind::graph: {
        const LabelledGraph file = readLabelledGraph(path, input_.parsed(), job.options);
        content.addLabels(file.labels);
        return append(content.graph, file.graph);
      }
      default:
        return addRecording(path, job, content);
    }
  }

  static void addMap(const SemanticMap& map, Content& content) {
    content.addLabels(map.labels);
    append(content.graph, map.graph);
    appendCloud(content.cloud, map.cloud);
    if (content.plan.sampleCount() == 0) content.plan = map.plan;
    for (const Keyframe& keyframe : map.keyframes) content.poses.push_back(keyframe.T_map_sensor);
  }

  void addRecording(const std::string& path, const Job& job, Content& content) const {
    const auto source = openInput(path, input_.parsed(), job);
    LiftCounts counts;
    LabelledCloud cloud = liftAll(*source, job, counts);
    if (voxel_m_ > 0) cloud = thinByVoxel(cloud, voxel_m_);
    content.addLabels(source->labels());
    appendCloud(content.cloud, cloud);
    for (std::size_t i = 0; i < source->size(); ++i) content.poses.push_back(source->pose(i));
  }

  static void addAnswers(const std::string& path, DrawnAnswers& drawn, Content& content) {
    for (const Answer& answer : readAnswers(path)) {
      if (!answer.fix.hypotheses.empty()) content.queries.push_back(drawn.draw(answer));
    }
  }

  static Scene sceneOf(const Content& content, const std::vector<std::string>& files) {
    Scene scene;
    for (const std::string& file : files) scene.title += (scene.title.empty() ? "" : ", ") + file;
    scene.labels = &content.labels;
    scene.map_graph = &content.graph;
    scene.map_cloud = &content.cloud;
    scene.map_plan = &content.plan;
    scene.map_poses = content.poses;
    scene.queries = content.queries;
    return scene;
  }

  InputFlags input_;
  std::string out_;
  double voxel_m_ = 0.1;
};

}  // namespace

std::unique_ptr<Command> makeView() { return std::make_unique<ViewCommand>(); }

}  // namespace xview::tools
