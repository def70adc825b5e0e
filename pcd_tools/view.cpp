// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <deque>
#include <filesystem>
#include <map>

#include "answer.h"
#include "inputs.h"
#include "outputs.h"
#include "xview/graph/lift.h"
#include "xview/io/graph_files.h"
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

void addLabels(const LabelSet& more, LabelSet& labels) {
  for (const auto& [id, info] : more.classes()) {
    if (!labels.find(id)) labels.add(info);
  }
}

bool isGraph(const std::string& path) {
  return fs::path(path).extension() == ".ply" && io::recogniseInput(path) == io::InputKind::graph;
}

/// The rectangle around a cloud, in the colour of the answer.
SceneLine outlineOf(const LabelledCloud& cloud, const SceneQuery& query) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < cloud.size(); ++i) box.extend(cloud.position(i));
  SceneLine line;
  line.name = std::string("query, ") + toString(query.status);
  line.color = statusColor(query.status);
  for (const int corner : {0, 1, 3, 2, 0}) {
    line.points.push_back(query.T_map_query *
                          box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  return line;
}

/// Lengths of the query become those of the map.
void scaleBy(double scale, SemanticGraph& graph) {
  for (Vertex& v : graph.vertices) v.position *= scale;
}
void scaleBy(double scale, LabelledCloud& cloud) {
  cloud.origin *= scale;
  for (Point& p : cloud.points) p.getVector3fMap() *= static_cast<float>(scale);
}

/// Answers as they are drawn into the map: with the way of the query if its recording is still
/// there, else with the pose alone. What has no way, a cloud or a graph, is drawn itself.
class DrawnAnswers {
 public:
  DrawnAnswers(const InputFlags& input, double voxel_m, const Job& job)
      : input_(input), voxel_m_(voxel_m), job_(job) {}

  /// The clouds and graphs in the result live as long as this object.
  SceneQuery draw(const Answer& answer);
  const std::vector<SceneLine>& outlines() const { return outlines_; }  ///< of the clouds drawn

 private:
  const FrameSource* recordingOf(const std::string& path);  ///< null if it cannot be opened
  void drawWay(const FrameSource& recording, const Answer& answer, SceneQuery& query);
  void drawCloud(const FrameSource& recording, double scale, SceneQuery& query);

  const InputFlags& input_;
  double voxel_m_;
  const Job& job_;
  std::map<std::string, std::unique_ptr<FrameSource>> recordings_;
  std::deque<LabelledCloud> clouds_;
  std::deque<SemanticGraph> graphs_;
  std::vector<SceneLine> outlines_;
};

const FrameSource* DrawnAnswers::recordingOf(const std::string& path) {
  const auto known = recordings_.find(path);
  if (known != recordings_.end()) return known->second.get();
  std::unique_ptr<FrameSource> recording;
  try {
    io::InputOptions whole = input_.parsed();
    whole.frames = {};
    recording = io::openRecording(path, whole);
  } catch (const Error& e) {
    job_.narrate.note(fmt::format("only the poses of {} are drawn: {}", path, e.what()));
  }
  return recordings_.emplace(path, std::move(recording)).first->second.get();
}

SceneQuery DrawnAnswers::draw(const Answer& answer) {
  SceneQuery query;
  query.name = fmt::format("{} {}-{}", answer.input, answer.first_frame, answer.last_frame);
  query.status = answer.fix.status;
  query.T_map_query = answer.fix.T_map_sensor;
  query.poses = {Eigen::Isometry3d::Identity()};  // as if its odometry began there
  if (!fs::exists(answer.input)) return query;
  if (isGraph(answer.input)) {
    graphs_.push_back(io::readGraph(answer.input).graph);
    scaleBy(answer.fix.scale, graphs_.back());
    query.graph = &graphs_.back();
  } else if (const FrameSource* recording = recordingOf(answer.input)) {
    drawWay(*recording, answer, query);
  }
  return query;
}

void DrawnAnswers::drawWay(const FrameSource& recording, const Answer& answer, SceneQuery& query) {
  std::vector<Eigen::Isometry3d> way;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const std::int64_t number = recording.number(i);
    if (number < answer.first_frame || number > answer.last_frame) continue;
    way.push_back(recording.pose(i));
    way.back().translation() *= answer.fix.scale;
  }
  if (way.empty()) return;  // another recording than the one that was answered
  if (recording.sensor() == Sensor::lidar) query.forward = Eigen::Vector3d::UnitX();
  query.T_map_query = answer.fix.T_map_sensor * way.back().inverse();
  query.poses = std::move(way);
  if (recording.sensor() == Sensor::cloud) drawCloud(recording, answer.fix.scale, query);
}

void DrawnAnswers::drawCloud(const FrameSource& recording, double scale, SceneQuery& query) {
  LabelledCloud cloud = liftAll(recording, job_, 0);
  scaleBy(scale, cloud);
  clouds_.push_back(voxel_m_ > 0 ? graph::thinByVoxel(cloud, voxel_m_) : std::move(cloud));
  query.cloud = &clouds_.back();
  outlines_.push_back(outlineOf(clouds_.back(), query));
  query.poses.clear();  // the origin of a cloud is no place where anything was
}

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
    requireDrawingPath(out);
    Stopwatch watch;
    map::SemanticMap content;  // everything that is shown together, in one frame
    std::vector<SceneQuery> queries;
    DrawnAnswers drawn(input_, voxel_m_, job);
    for (const std::string& file : files) {
      if (fs::path(file).extension() == ".jsonl")
        addAnswers(file, drawn, queries);
      else
        add(file, job, content);
    }
    job.narrate.stage("read", watch.lap_ms(),
                      fmt::format("{} vertices, {} points, {} queries", content.graph.size(),
                                  content.cloud.size(), queries.size()));
    Scene scene = sceneOf(content, fmt::format("{}", fmt::join(files, ", ")));
    scene.queries = std::move(queries);
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

  void add(const std::string& path, const Job& job, map::SemanticMap& content) const {
    switch (io::recogniseInput(path, input_.parsed())) {
      case io::InputKind::map:
        return addMap(map::loadMap(path), content);
      case io::InputKind::graph: {
        const LabelledGraph file = readLabelledGraph(path, input_.parsed(), job.options);
        addLabels(file.labels, content.labels);
        return append(content.graph, file.graph);
      }
      default:
        return addRecording(path, job, content);
    }
  }

  static void addMap(const map::SemanticMap& map, map::SemanticMap& content) {
    addLabels(map.labels, content.labels);
    append(content.graph, map.graph);
    appendCloud(content.cloud, map.cloud);
    if (content.plan.sampleCount() == 0) content.plan = map.plan;
    content.poses.insert(content.poses.end(), map.poses.begin(), map.poses.end());
  }

  void addRecording(const std::string& path, const Job& job, map::SemanticMap& content) const {
    const auto source = openInput(path, input_.parsed(), job);
    addLabels(source->labels(), content.labels);
    appendCloud(content.cloud, liftAll(*source, job, voxel_m_));
    for (std::size_t i = 0; i < source->size(); ++i) content.poses.push_back(source->pose(i));
  }

  static void addAnswers(const std::string& path, DrawnAnswers& drawn,
                         std::vector<SceneQuery>& queries) {
    for (const Answer& answer : readAnswers(path)) {
      if (!answer.fix.hypotheses.empty()) queries.push_back(drawn.draw(answer));
    }
  }

  InputFlags input_;
  std::string out_;
  double voxel_m_ = 0.1;
};

}  // namespace

std::unique_ptr<Command> makeView() { return std::make_unique<ViewCommand>(); }

}  // namespace xview::tools
