// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "base/median.h"
#include "inputs.h"
#include "outputs.h"
#include "scenes.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/io/pose_files.h"
#include "xview/map/semantic_map.h"

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

class ViewCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "view",
        "FILE... [OUT]",
        "a picture, page, mesh or cloud of maps, recordings, graphs, clouds and answers",
        "FILEs share one frame; answers of localize --json (.jsonl) are drawn into the map before "
        "them, with the way, cloud or graph of the query if it is found. OUT ends with .png, .svg, "
        ".html, .vtk, .ply or .pcd. A last FILE that does not exist is OUT, too; one that exists "
        "is written over with -o only. Without OUT the picture is FILE.png in the working folder.",
        "xview view town.xvm rear.jsonl -o rear.png",
        1,
        1000};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.addOutput("-o,--out", out_, "the file to write");
    flags.add("--voxel", voxel_m_,
              "thin recordings to one point per voxel and class; a cloud of up to 100,000 points "
              "stays [m]");
  }

  ExitCode run(const Job& job) override {
    std::vector<std::string> files = job.operands;
    const std::string out = takeOut(files, job);
    requireOutside("", out, files);
    requireDrawingPath(out);
    Stopwatch watch;
    Content content;
    std::vector<SceneQuery> queries;
    DrawnAnswers drawn(input_, voxel_m_, job, files);
    const auto is_answers = [](const std::string& f) { return endingOf(f) == ".jsonl"; };
    std::stable_partition(files.begin(), files.end(), [&](const std::string& f) {
      return endingOf(f) == ".xvm";  // its classes come first
    });
    std::set<std::string> maps;  // that answers name and nobody gave
    for (const std::string& file : files) {
      if (!is_answers(file)) continue;
      maps.insert(drawn.mapBehind(file));
      for (SceneQuery& query : drawn.draw(file, content.labels))
        queries.push_back(std::move(query));
    }
    for (const std::string& map : maps) {
      if (!map.empty()) add(map, job, content);
    }
    for (const std::string& file : files) {
      if (!is_answers(file) && !drawn.isQuery(file)) add(file, job, content);
    }
    job.narrate.stage("read", watch.lap_ms(),
                      fmt::format("{} vertices, {} points, {} queries", content.map.graph.size(),
                                  content.map.cloud.size(), queries.size()));
    if (content.map.graph.empty() && content.map.cloud.empty() && queries.empty() &&
        content.ways.empty())
      throw Error(files[0], "nothing to draw: it holds no points, vertices or poses");
    Scene scene = sceneOf(content.map);
    scene.labels = &content.labels.labels();
    scene.queries = std::move(queries);
    scene.lines = content.ways;
    describe(files, job, content, scene);
    writeDrawing(out, scene, job.narrate);
    job.narrate.stage("view", watch.lap_ms(), out);
    fmt::print("{}\n", out);
    return kDone;
  }

 private:
  /// True for the picture of an earlier run of just this command.
  static bool isMadeBy(const std::string& picture, const Job& job) {
    std::ifstream file(picture, std::ios::binary);
    std::string beginning(8192, '\0');
    file.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
    const std::size_t first = beginning.find("xview view "), end = beginning.find(" · ", first);
    // What is said meanwhile, and by how many threads it is drawn, changes no picture.
    static const std::regex kWithoutEffect(" (-q|--quiet|-v|--verbose|--threads[ =]\\d+)(?= |$)");
    const auto drawing = [](const std::string& line) {
      return std::regex_replace(line, kWithoutEffect, "");
    };
    return end != std::string::npos &&
           drawing(beginning.substr(first, end - first)) == drawing(job.command_line);
  }

  /// The output, removed from the operands if it was the last of them: a file that is not there
  /// yet, or one that could not be an input.
  std::string takeOut(std::vector<std::string>& files, const Job& job) const {
    if (!out_.empty()) return out_;
    const std::string last = files.back(), ending = endingOf(last);
    static const std::set<std::string> kInputs = {"", ".xvm", ".jsonl", ".bin", ".tum", ".txt"};
    if (files.size() > 1 && !fs::exists(last) && kInputs.count(ending) == 0)
      requireDrawingPath(last);
    if (files.size() > 1 && isDrawing(last)) {
      if (!fs::exists(last)) {
        files.pop_back();
        return last;
      }
      if (!isCloudPath(last))
        throw UsageError(fmt::format("{} exists already; -o {} writes it anew", last, last));
    }
    fs::path first = fs::path(files[0]).lexically_normal();
    if (!first.has_filename()) first = first.parent_path();  // "town/"
    const std::string guess = first.filename().string() + ".png";
    if (fs::exists(guess) && !isMadeBy(guess, job))
      throw UsageError(fmt::format(
          "{} exists already, and not of this command; -o {} writes it anew", guess, guess));
    return guess;
  }

  /// Everything that is shown together, in one frame.
  struct Content {
    Place map;
    JoinedLabels labels;
    std::vector<SceneLine> ways;
  };

  /// Title, caption and headline numbers.
  static void describe(const std::vector<std::string>& files, const Job& job,
                       const Content& content, Scene& scene) {
    const std::string names = fmt::format("{}", fmt::join(files, ", "));
    std::string size;
    for (const auto& [name, count] : {std::pair("vertices", content.map.graph.size()),
                                      std::pair("points", content.map.cloud.size()),
                                      std::pair("key frames", content.map.poses.size())}) {
      if (count == 0) continue;
      scene.facts.emplace_back(name, std::to_string(count));
      size += fmt::format("{}{} {}", size.empty() ? "" : ", ", count, name);
    }
    scene.title = scene.queries.empty() ? names : outcomeOf(scene.queries);
    scene.caption = scene.queries.empty() ? size : names + ": " + size;
    scene.made_by = madeBy(job);
    std::vector<double> times_ms;
    for (const SceneQuery& query : scene.queries) {
      if (std::isfinite(query.total_ms)) times_ms.push_back(query.total_ms);
    }
    if (!times_ms.empty())
      scene.facts.emplace_back("time per query",
                               fmt::format("{:.2f} s", medianOf(times_ms) / 1000));
    const auto is_accepted = [](const SceneQuery& q) { return q.status == Status::accepted; };
    if (scene.queries.size() == 1)
      scene.caption = names + ": " + scene.queries[0].reason;
    else if (!scene.queries.empty() &&
             std::none_of(scene.queries.begin(), scene.queries.end(), is_accepted))
      scene.caption =
          fmt::format("{}: {}: {}", names, scene.queries[0].name, scene.queries[0].reason);
  }

  void add(const std::string& path, const Job& job, Content& content) const {
    const std::string ending = endingOf(path);
    if (ending == ".tum" || ending == ".txt") return addWay(path, content);
    if (ending == ".csv" && isTableOfAnswers(path))
      throw UsageError(path +
                       ": of answers view reads .jsonl; localize -o answers.jsonl writes them");
    Place place = readDrawable(path, input_.parsed(), job, voxel_m_);
    content.labels.adopt(place);
    append(content.map.graph, place.graph);
    content.map.cloud.append(place.cloud);
    if (content.map.bev.sampleCount() == 0) content.map.bev = std::move(place.bev);
    content.map.poses.insert(content.map.poses.end(), place.poses.begin(), place.poses.end());
  }

  static bool isTableOfAnswers(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    return std::getline(file, line) && line == csvHeading();
  }

  /// A trajectory, such as that of localize --trajectory.
  static void addWay(const std::string& path, Content& content) {
    SceneLine way{fs::path(path).filename().string(), kWayColor, {}};
    for (const io::StampedPose& pose : io::readPoses(path))
      way.points.push_back(pose.T_frame_sensor.translation());
    content.ways.push_back(std::move(way));
  }

  static constexpr Color kWayColor{30, 96, 214};
  InputFlags input_;
  std::string out_;
  double voxel_m_ = 0.1;
};

}  // namespace

std::unique_ptr<Command> makeView() { return std::make_unique<ViewCommand>(); }

}  // namespace xview::tools
