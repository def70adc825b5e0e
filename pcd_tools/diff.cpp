// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>

#include "answer_table.h"
#include "base/user_text.h"
#include "compare/changes.h"
#include "io/graph_files.h"
#include "localizer/query_in_map.h"
#include "outputs.h"
#include "place/raw_recording.h"
#include "placed_visit.h"
#include "process/atomic_file.h"
#include "scenes.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/base/localization.h"
#include "xview/io/label_files.h"

namespace xview::tools {
namespace {

using What = Change::What;

Color colorOf(What what) {
  if (what == What::gone) return {206, 44, 44};
  return what == What::added ? Color{22, 138, 62} : Color{216, 120, 0};
}

std::size_t countOf(const Changes& changes, What what, bool is_dynamic = false) {
  return static_cast<std::size_t>(
      std::count_if(changes.changes.begin(), changes.changes.end(),
                    [&](const Change& c) { return c.what == what && c.is_dynamic == is_dynamic; }));
}

/// "3 gone, 2 new, 1 moved"
std::string headlineOf(const Changes& changes) {
  return fmt::format("{} gone, {} new, {} moved", countOf(changes, What::gone),
                     countOf(changes, What::added), countOf(changes, What::moved));
}

/// What is expected to change from day to day; empty if nothing did.
std::string passingOf(const Changes& changes) {
  const std::size_t gone = countOf(changes, What::gone, true),
                    added = countOf(changes, What::added, true);
  return gone + added > 0 ? fmt::format("{} gone, {} new", gone, added) : "";
}

std::string summaryOf(const Changes& changes) {
  const std::string passing = passingOf(changes);
  return fmt::format("{} (of {} landmarks seen by both){}", headlineOf(changes), changes.compared,
                     passing.empty() ? "" : "; of classes that move anyway " + passing);
}

/// "pole, ±3 cm, 97 %, moved by 2.10 m"
std::string noteOf(const Change& change, const LabelSet& labels) {
  std::string text = fmt::format("{}, ±{}, {:.0f} %", labels.className(change.label),
                                 lengthText(change.sigma_m), std::floor(100 * change.probability));
  if (change.moved_to)
    text += fmt::format(", moved by {:.2f} m", (*change.moved_to - change.position).norm());
  return text;
}

std::string toCsv(const Changes& changes, const LabelSet& labels) {
  std::string text =
      "change,class,dynamic,x,y,z,size_x,size_y,size_z,sigma,probability,to_x,to_y,to_z\n";
  for (const Change& c : changes.changes) {
    text += fmt::format("{},{},{},{:.3f},{:.3f},{:.3f},{:.2f},{:.2f},{:.2f},{:.3f},{:.4f},",
                        toString(c.what), csvQuoted(labels.className(c.label)),
                        c.is_dynamic ? 1 : 0, c.position.x(), c.position.y(), c.position.z(),
                        c.extent.x(), c.extent.y(), c.extent.z(), c.sigma_m, c.probability);
    text += c.moved_to ? fmt::format("{:.3f},{:.3f},{:.3f}\n", c.moved_to->x(), c.moved_to->y(),
                                     c.moved_to->z())
                       : std::string(",,\n");
  }
  return text;
}

/// A class for each change of a class: "gone pole".
LabelSet changeLabels(const Changes& changes, const LabelSet& labels,
                      std::vector<std::uint32_t>& ids) {
  LabelSet set("changes");
  std::map<std::string, std::uint32_t> known;
  for (const Change& c : changes.changes) {
    const std::string name = std::string(toString(c.what)) + " " + labels.className(c.label);
    const auto [at, is_new] = known.emplace(name, known.size() + 1);
    ids.push_back(at->second);
    if (is_new)
      set.add({at->second, name, colorOf(c.what), c.is_dynamic ? Role::dynamic : Role::object,
               labels.kind(c.label), false});
  }
  return set;
}

/// One vertex for each change, and two with an edge for what moved.
void writeChangeGraph(const std::string& path, const Changes& changes, const LabelSet& labels) {
  std::vector<std::uint32_t> ids;
  const LabelSet set = changeLabels(changes, labels, ids);
  SemanticGraph graph;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Change& change = changes.changes[i];
    Vertex vertex;
    vertex.label = ids[i];
    vertex.position = change.position;
    vertex.extent = change.extent;
    vertex.sigma_m = change.sigma_m;
    graph.vertices.push_back(vertex);
    if (!change.moved_to) continue;
    vertex.position = *change.moved_to;
    graph.vertices.push_back(vertex);
    const auto last = static_cast<std::uint32_t>(graph.size() - 1);
    edges.emplace_back(last - 1, last);
  }
  graph.setEdges(edges);
  io::writeGraph(path, graph, set);
}

class DiffCommand final : public Command {
 public:
  Description describe() const override {
    return {"diff",
            "MAP MAP|RECORDING",
            "what appeared, disappeared or moved between two visits",
            "The second visit is localized in the first (exit code 3 if it is not accepted). A "
            "landmark is gone where the second visit sees through its place or sees something of "
            "another class there, new the other way round; what one of them did not see, or what "
            "only a few of its frames saw, is not spoken of. OUT.csv is a table, OUT.ply a graph "
            "of the changes, OUT.png or OUT.svg a picture, OUT.html a page, OUT.vtk a mesh, "
            "OUT.pcd a cloud.",
            "xview diff town.xvm town/later -o changes.html",
            2,
            2};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    verdict_.declare(flags);
    flags.addOutput("-o,--out", out_, "the file to write");
  }

  ExitCode run(const Job& given) override {
    if (!out_.empty()) requireDrawingPath(out_, true);
    if (!given.options.scale.empty())
      throw UsageError("--scale: only visits with the same lengths can be compared");
    map::SemanticMap earlier = readWholeMap(given.operands[0], input_, given);
    Job job = inMap(given, earlier);
    verdict_.applyTo(job);
    Stopwatch watch;
    const std::optional<PlacedVisit> later = find(job.operands[1], earlier, job);
    if (!later) {
      removeStale(out_, job.narrate);
      return kNoPose;
    }
    job.narrate.stage("localize", watch.lap_ms(), later->how);
    const Changes changes = findChanges(earlier, later->place, later->T_map_visit, later->sigma_m);
    if (!changes.has_looked) requireLooks(earlier, job);
    job.narrate.stage("diff", watch.lap_ms(), fmt::format("{} changes", changes.changes.size()));
    write(changes, earlier, *later, job);
    logChanges(changes, earlier.labels, job.narrate);
    if (changes.compared == 0)
      job.narrate.note(
          "no landmark of the earlier visit was seen by the later one, which says nothing about "
          "changes");
    fmt::print("{}\n", printable(summaryOf(changes)));
    return kDone;
  }

 private:
  /// Nothing if it is not accepted, which is said.
  std::optional<PlacedVisit> find(const std::string& path, map::SemanticMap& earlier,
                                  const Job& job) const {
    QueryInput input = openQuery(path, input_, job, earlier.labels);
    if (input.labels.name() == kShapes && earlier.labels.name() != kShapes)
      map::reduceToShapes(io::shippedLabelSet(kShapes), earlier);
    const Localizer localizer(map::borrowed(earlier), job.options, input.options.class_names);
    std::string refusal;
    std::optional<PlacedVisit> found = placeVisit(input, localizer, job, refusal);
    if (!found)
      fmt::print("{}\n", oneLine(path + ": not found in the map, nothing is compared: " + refusal));
    return found;
  }

  /// One of the visits is to blame.
  [[noreturn]] static void requireLooks(const Place& earlier, const Job& job) {
    const bool first = earlier.bev.known.empty() || earlier.cloud.empty();
    throw Error(job.operands[first ? 0 : 1],
                "does not tell where it has looked, so nothing can be said to be gone or new; give "
                "a recording, or a map that was made of one");
  }

  void write(const Changes& changes, const map::SemanticMap& earlier, const PlacedVisit& later,
             const Job& job) const {
    const std::string ending = endingOf(out_);
    if (out_.empty()) return;
    if (ending == ".csv") return writeFile(out_, toCsv(changes, earlier.labels));
    if (ending == ".ply") return writeChangeGraph(out_, changes, earlier.labels);
    writeDrawing(out_, sceneOf(changes, earlier, later, job), job.narrate);
  }

  static Scene sceneOf(const Changes& changes, const map::SemanticMap& earlier,
                       const PlacedVisit& later, const Job& job) {
    Scene scene = tools::sceneOf(earlier);
    scene.title = headlineOf(changes);
    scene.caption = fmt::format("{} and, later, {}: {} landmarks seen by both", job.operands[0],
                                job.operands[1], changes.compared);
    scene.made_by = madeBy(job);
    SceneLine way{"way of the later visit", {90, 110, 200}, {}};
    for (const Eigen::Isometry3d& T : later.poses) way.points.push_back(T.translation());
    if (way.points.size() > 1) scene.lines.push_back(std::move(way));
    for (const Change& c : changes.changes) {
      const std::string group =
          toString(c.what) + std::string(c.is_dynamic ? " (moves anyway)" : "");
      Color color = colorOf(c.what);
      if (c.is_dynamic)
        for (std::uint8_t& part : color) part = static_cast<std::uint8_t>((part + 2 * 200) / 3);
      scene.marks.push_back({group, color, c.position, noteOf(c, earlier.labels), !c.is_dynamic});
      if (c.moved_to) scene.lines.push_back({"moved", color, {c.position, *c.moved_to}});
    }
    for (const What what : {What::gone, What::added, What::moved})
      scene.facts.emplace_back(toString(what), std::to_string(countOf(changes, what)));
    scene.facts.emplace_back("seen by both", std::to_string(changes.compared));
    if (const std::string passing = passingOf(changes); !passing.empty())
      scene.facts.emplace_back("of classes that move anyway", passing);
    return scene;
  }

  void logChanges(const Changes& changes, const LabelSet& labels, const Narrative& narrate) const {
    constexpr std::size_t kMost = 12;
    std::size_t said = 0;
    for (const Change& c : changes.changes) {
      if (c.is_dynamic || said == kMost) continue;
      ++said;
      narrate.line(fmt::format("{:5}  x {:.2f}, y {:.2f}, z {:.2f} m  {}", toString(c.what),
                               c.position.x(), c.position.y(), c.position.z(), noteOf(c, labels)));
    }
    if (said == kMost && out_.empty()) narrate.line("-o changes.csv lists all of them");
  }

  InputFlags input_;
  VerdictFlags verdict_;
  std::string out_;
};

}  // namespace

std::unique_ptr<Command> makeDiff() { return std::make_unique<DiffCommand>(); }

}  // namespace xview::tools
