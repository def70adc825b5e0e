// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <optional>
#include <set>

#include "answer_files.h"
#include "answer_table.h"
#include "base/user_text.h"
#include "consistency_checks.h"
#include "inputs.h"
#include "map/contents.h"
#include "map_changes.h"
#include "outputs.h"
#include "placed_visit.h"
#include "process/atomic_file.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"

namespace xview::tools {
namespace {

class MapCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "map",
        "INPUT... MAP.xvm",
        "build a map from recordings or graphs in one frame",
        "All inputs must share one frame: their poses are taken as they are; with --join the frame "
        "is that of the first, and the others are looked for in it. An existing map is replaced, "
        "or with --append kept and added to; either happens as a whole or not at all.",
        "xview map town/forward town.xvm",
        1,
        100000,
        true};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--append", append_, "add to an existing map");
    flags.add("--join", join_,
              "find each INPUT, or each setup of an E57, in the map of those before it");
    flags.addOutput("--matrix", matrices_,
                    "with --join: write where each INPUT is, 4 x 4 numbers (T_map_input), to a "
                    "file of its name in this folder");
    verdict_.declare(flags);
    flags.add("--without SOURCE", without_, "take out of MAP what was added from there");
    flags.add("--undo", undo_, "take back the last change of MAP");
    flags.add("--force", force_,
              "take also what contradicts the map or the other inputs, or is in it already");
  }

  RecordingsOfMap recordings(const Job& job) const override {
    const std::vector<std::string> inputs(job.operands.begin(), job.operands.end() - 1);
    const std::string& out = job.operands.back();
    if (join_) return {};
    if (!append_ || !std::filesystem::exists(out))
      return {openRecordings(inputs, nullptr, job, [](const auto&...) {}), job.options};
    const map::SemanticMap map = map::openMap(out);
    const Job sized = inMap(job, map);
    return {openRecordings(inputs, &map.labels, sized, [](const auto&...) {}), sized.options};
  }

  ExitCode run(const Job& given) override {
    Job job = given;
    if (!join_ && verdict_.any())
      throw UsageError("--risk, --timeout and --max-memory are for --join");
    verdict_.applyTo(job);
    std::vector<std::string> inputs(job.operands.begin(), job.operands.end() - 1);
    const std::string& out = job.operands.back();
    if (endingOf(out) != ".xvm")
      throw UsageError(out + ": a map ends with .xvm; the last operand is the map to write");
    if (undo_ || !without_.empty()) {
      if (!inputs.empty() || append_ || join_ || (undo_ && !without_.empty()))
        throw UsageError("--undo and --without are for a MAP alone");
      return undo_ ? undoLast(out) : takeOut(out, without_, job);
    }
    if (inputs.empty()) throw UsageError("xview map needs INPUT... MAP.xvm, found 1 operand");
    const bool exists = std::filesystem::exists(out);
    if (exists && !map::isMapFile(out))
      throw Error(out, "exists and is no map; the last operand is the map to write");
    requireWritable(out);
    if (join_) inputs = setupsOfAll(inputs);
    if (!matrices_.empty()) prepareMatrices(inputs);
    const map::MapLock lock(out);
    if (join_) return joinAll(inputs, out, job);
    return append_ && exists ? appendAll(inputs, out, job) : buildNew(inputs, out, job);
  }

 private:
  ExitCode buildNew(const std::vector<std::string>& inputs, const std::string& out,
                    const Job& job) {
    Stopwatch watch;
    std::optional<map::SemanticMap> map;
    for (map::SemanticMap& part : build(inputs, nullptr, job)) {
      if (!map) {
        map = std::move(part);
        continue;
      }
      logConsistencyChecks(*map, map->sources.front(), part, job.options, job.narrate);
      appendToMap(*map, part, job.options);
    }
    logBuilt(inputs.size(), watch, job);
    map::saveMap(out, *map);
    job.narrate.stage("save", watch.lap_ms(), out);
    printMap(out, *map);
    return kDone;
  }

  ExitCode appendAll(const std::vector<std::string>& inputs, const std::string& out,
                     const Job& given) {
    Stopwatch watch;
    map::SemanticMap map = map::openMap(out);
    const Job job = inMap(given, map);
    MapDraft draft(out, out);
    for (map::SemanticMap& part : build(inputs, &map.labels, job)) {
      if (!force_) requireFits(map, out, part, job);
      appendToMap(map, part, job.options);
      const std::string note = fmt::format("appended {}", fmt::join(part.sources, ", "));
      draft.add(map, note, {std::move(part), 0});
    }
    logBuilt(inputs.size(), watch, job);
    draft.commit();
    job.narrate.stage("save", watch.lap_ms(), out);
    printMap(out, map);
    return kDone;
  }

  /// Each setup of an E57 is an input. What is not there is not waited for behind hours of work.
  static std::vector<std::string> setupsOfAll(const std::vector<std::string>& inputs) {
    std::vector<std::string> all;
    for (const std::string& input : inputs) {
      if (input.find('#') == std::string::npos && !std::filesystem::exists(input))
        throw Error(input, "no such file or folder");
      try {
        const std::vector<std::string> setups = io::setupsOf(input);
        all.insert(all.end(), setups.begin(), setups.end());
      } catch (const Error&) {  // it is said when its turn comes
        all.push_back(input);
      }
    }
    return all;
  }

  /// Those that were not found are tried again as long as the map grows.
  ExitCode joinAll(const std::vector<std::string>& inputs, const std::string& out,
                   const Job& given) {
    Stopwatch watch;
    const bool onto = append_ && std::filesystem::exists(out);
    map::SemanticMap map = onto ? map::openMap(out) : readMap(inputs.front(), input_, given);
    const Job job = inMap(given, map);
    MapDraft draft = onto ? MapDraft(out, out) : MapDraft(out, map);
    std::vector<std::string> waiting(inputs.begin() + (onto ? 0 : 1), inputs.end());
    if (!onto) joined_.emplace_back(inputs.front(), Eigen::Isometry3d::Identity());
    const std::size_t all = waiting.size(), joined_before = joined_.size();
    std::vector<std::string> refusals;
    for (std::size_t before = all + 1; !waiting.empty() && waiting.size() < before;) {
      before = waiting.size();
      refusals.clear();
      std::vector<std::string> left;
      for (const std::string& path : waiting) {
        const std::string refusal = join(path, map, draft, job);
        if (refusal.empty() || unreadable_.count(path)) continue;
        left.push_back(path);
        refusals.push_back(refusal);
      }
      waiting = std::move(left);
    }
    for (std::size_t i = 0; i < waiting.size(); ++i)
      fmt::print("{}: left out: {}\n", printable(waiting[i]), printable(refusals[i]));
    const ExitCode unread = unreadable_.empty() ? kDone : kFailed;
    const std::size_t found = joined_.size() - joined_before;
    if (found == 0) return unread ? unread : kNoPose;
    draft.commit();
    if (!matrices_.empty()) writeMatrices();
    job.narrate.stage("join", watch.lap_ms(), fmt::format("{} of {} found", found, all));
    printMap(out, map);
    return unread;
  }

  /// Adds an input where it is found; else why it is not.
  std::string join(const std::string& path, map::SemanticMap& map, MapDraft& draft,
                   const Job& job) {
    std::string refusal;
    std::optional<PlacedVisit> placed;
    std::optional<map::Visit> visit;
    try {
      QueryInput input = openQuery(path, input_, job, map.labels);
      placed =
          placeVisit(input, Localizer(map::borrowed(map), job.options, input.options.class_names),
                     job, refusal);
      if (!placed) return refusal;
      visit = additionOf(*placed, input, input_, map, job);
    } catch (const std::runtime_error& error) {  // one of many need not be readable
      unreadable_.insert(path);
      job.narrate.error(error.what());
      return error.what();
    }
    if (const auto objection = objectionTo(visit->place, map, "the map", job.options))
      return *objection;
    job.narrate.line(placed->how);
    joined_.emplace_back(path, placed->T_map_input);
    appendToMap(map, visit->place, job.options);
    draft.add(map, fmt::format("joined {}, wrong {}", path, chanceWrongText(placed->confidence)),
              *visit);
    return "";
  }

  /// Beside every input that is in the map, and no others of before.
  void writeMatrices() const {
    for (const auto& [path, T_map_input] : joined_) io::writeMatrix(matrixOf(path), T_map_input);
  }
  std::string matrixOf(const std::string& input) const {
    return (std::filesystem::path(matrices_) / (stemOf(input) + ".txt")).string();
  }
  void prepareMatrices(const std::vector<std::string>& inputs) const {
    if (!join_) throw UsageError("--matrix is for --join");
    requireDistinct(inputs);
    for (const std::string& input : inputs) {
      std::error_code failed;
      if (std::filesystem::equivalent(input, matrices_, failed))
        throw UsageError("--matrix " + matrices_ + " is an input");
    }
    makeFolder(matrices_);
    for (const std::string& input : inputs) std::filesystem::remove(matrixOf(input));
  }

  static void logBuilt(std::size_t inputs, Stopwatch& watch, const Job& job) {
    job.narrate.stage("map", watch.lap_ms(),
                      fmt::format("{} {}", inputs, inputs == 1 ? "input" : "inputs"));
  }

  static void printMap(const std::string& out, const map::SemanticMap& map) {
    fmt::print("{}: {}\n", out, contentsText(map));
    if (const std::string own = ownAcceptanceText(map); !own.empty())
      fmt::print("own windows of {}\n", own);
    if (const std::string wrong = wrongPlacesText(map); !wrong.empty())
      fmt::print("wrong places {}\n", wrong);
  }

  /// One map of all recordings, and one of each graph or map.
  std::vector<map::SemanticMap> build(const std::vector<std::string>& inputs,
                                      const LabelSet* added_to, const Job& job) const {
    std::vector<map::SemanticMap> parts;
    const auto recordings = openRecordings(
        inputs, added_to, job, [&](const std::string& path, const io::InputOptions& input) {
          parts.push_back(mapOf(path, input, job));
        });
    if (!recordings.empty()) {
      const RecordingsUse use = added_to ? RecordingsUse::addition : RecordingsUse::map;
      parts.insert(parts.begin(), buildOfRecordings(recordings, use, job));
    }
    return parts;
  }

  /// Those among the inputs; take_other(path, options) gets graphs and maps. Inputs that name no
  /// classes have those of the map that they are `added_to`, else of the first recording.
  template <class TakeOther>
  std::vector<std::unique_ptr<FrameSource>> openRecordings(const std::vector<std::string>& inputs,
                                                           const LabelSet* added_to, const Job& job,
                                                           const TakeOther& take_other) const {
    std::vector<std::unique_ptr<FrameSource>> recordings;
    io::InputOptions input = added_to ? inputIn(input_, *added_to) : input_.parsed();
    for (const std::string& path : inputs) {
      if (!added_to && !recordings.empty()) input.map_labels = recordings.front()->labels();
      const io::InputKind kind = io::recogniseInput(path, input);
      if (kind == io::InputKind::map || kind == io::InputKind::graph)
        take_other(path, input);
      else
        recordings.push_back(openPlaceInput(path, input, job));
    }
    return recordings;
  }

  map::SemanticMap buildOfRecordings(const std::vector<std::unique_ptr<FrameSource>>& recordings,
                                     RecordingsUse use, const Job& job) const {
    std::vector<const FrameSource*> sources;
    for (const auto& recording : recordings) sources.push_back(recording.get());
    const SharedRecordings shared(sources);
    SketchedRecordings sketches(sources, job.options);
    map::SemanticMap map = mapOfRecordings(
        sources, job, use, [&](const FrameSource& source, const PreprocessedFrame& frame) {
          if (sources.size() > 1) sketches.add(source, frame);
        });
    sketches.check(force_, job.narrate);
    if (map.graph.empty() && map.bev.sampleCount() == 0) {
      throw Error(recordings.front()->name(),
                  "nothing to make a map of: no blob of any known class");
    }
    return map;
  }

  InputFlags input_;
  VerdictFlags verdict_;
  std::string without_;
  std::string matrices_;
  std::vector<std::pair<std::string, Eigen::Isometry3d>> joined_;  ///< inputs, T_map_input
  std::set<std::string> unreadable_;
  bool append_ = false, join_ = false, undo_ = false, force_ = false;
};

}  // namespace

std::unique_ptr<Command> makeMap() { return std::make_unique<MapCommand>(); }

}  // namespace xview::tools
