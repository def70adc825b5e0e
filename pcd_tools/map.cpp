// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "doubts.h"
#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"
#include "xview/types/atomic_file.h"
#include "xview/types/error.h"
#include "xview/types/localization.h"

namespace xview::tools {
namespace {

class MapCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "map",
        "INPUT... MAP.xvm",
        "build a map from recordings or graphs in one frame",
        "All inputs must share one frame: their poses are taken as they are. An existing map is "
        "replaced, or with --append kept and added to; either happens as a whole or not at all.",
        "xview map town/forward town.xvm",
        2,
        100000,
        true};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--append", append_, "add to an existing map");
  }

  ExitCode run(const Job& job) override {
    const std::vector<std::string> inputs(job.operands.begin(), job.operands.end() - 1);
    const std::string& out = job.operands.back();
    if (endingOf(out) != ".xvm")
      throw UsageError(out + ": a map ends with .xvm; the last operand is the map to write");
    const bool exists = std::filesystem::exists(out);
    if (exists && !map::isMapFile(out))
      throw Error(out, "exists and is no map; the last operand is the map to write");
    requireWritable(out);

    const map::MapLock lock(out);
    Stopwatch watch;
    std::optional<map::SemanticMap> map;
    if (append_ && exists) map = map::loadMap(out);
    for (map::SemanticMap& part :
         build(inputs, map ? &map->labels : nullptr, map ? inMap(job, *map) : job)) {
      if (!map) {
        map = std::move(part);
        continue;
      }
      sayDoubts(*map, append_ && exists ? out : map->sources.front(), part, job.options,
                job.narrate);
      appendToMap(*map, part, job.options);
    }
    job.narrate.stage("map", watch.lap_ms(),
                      fmt::format("{} {}", inputs.size(), inputs.size() == 1 ? "input" : "inputs"));
    map::saveMap(out, *map);
    job.narrate.stage("save", watch.lap_ms(), out);
    fmt::print("{}: {} vertices, {} edges, {} key frames, {} points\n", out, map->graph.size(),
               map->graph.edgeCount(), map->poses.size(), map->cloud.size());
    if (const std::string own = ownAcceptanceText(*map); !own.empty())
      fmt::print("own windows of {}\n", own);
    return kDone;
  }

 private:
  /// One map of all recordings, and one of each graph or map. Inputs that name no classes have
  /// those of the map that they are `added_to`, else of the first recording.
  std::vector<map::SemanticMap> build(const std::vector<std::string>& inputs,
                                      const LabelSet* added_to, const Job& job) const {
    std::vector<map::SemanticMap> parts;
    std::vector<std::unique_ptr<FrameSource>> recordings;
    io::InputOptions input = added_to ? inputIn(input_, *added_to) : input_.parsed();
    for (const std::string& path : inputs) {
      if (!added_to && !recordings.empty()) input.map_labels = recordings.front()->labels();
      switch (io::recogniseInput(path, input)) {
        case io::InputKind::map:
        case io::InputKind::graph:
          parts.push_back(mapOf(path, input, job));
          break;
        default:
          recordings.push_back(openPlaceInput(path, input, job));
      }
    }
    if (!recordings.empty()) parts.insert(parts.begin(), buildOfRecordings(recordings, job));
    return parts;
  }

  map::SemanticMap buildOfRecordings(const std::vector<std::unique_ptr<FrameSource>>& recordings,
                                     const Job& job) const {
    std::vector<const FrameSource*> sources;
    for (const auto& recording : recordings) sources.push_back(recording.get());
    SketchedRecordings sketches(sources, job.options);
    map::SemanticMap map =
        mapOfRecordings(sources, job, [&](const FrameSource& source, const FrameDigest& frame) {
          if (sources.size() > 1) sketches.add(source, frame);
        });
    sketches.sayDoubts(job.narrate);
    if (map.graph.empty() && map.plan.sampleCount() == 0) {
      throw Error(recordings.front()->name(),
                  "nothing to make a map of: no blob of any known class");
    }
    return map;
  }

  InputFlags input_;
  bool append_ = false;
};

}  // namespace

std::unique_ptr<Command> makeMap() { return std::make_unique<MapCommand>(); }

}  // namespace xview::tools
