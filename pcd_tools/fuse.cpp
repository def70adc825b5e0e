// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "answer_table.h"
#include "doubts.h"
#include "inputs.h"
#include "outputs.h"
#include "tool.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/types/atomic_file.h"
#include "xview/types/error.h"
#include "xview/types/localization.h"
#include "xview/types/user_text.h"

namespace xview::tools {
namespace {

class FuseCommand final : public Command {
 public:
  Description describe() const override {
    return {"fuse",
            "QUERY MAP",
            "add an accepted query to the map (undo with --undo)",
            "The query is localized; if it is accepted it is brought into the map frame and added, "
            "else the map stays as it is (exit code 3). Either all of it happens or nothing. "
            "`xview fuse MAP --undo` takes the last addition back.",
            "xview fuse town/rear town.xvm",
            1,
            2};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--undo", undo_, "take back the last addition to MAP");
    flags.addOutput("-o,--out", out_, "write the larger map to this file and leave MAP alone");
  }

  ExitCode run(const Job& given) override {
    if (undo_) {
      if (!out_.empty()) throw UsageError("--undo changes MAP itself, without -o");
      return undo(given.operands.back());
    }
    if (given.operands.size() != 2) throw UsageError("xview fuse needs QUERY MAP, found 1 operand");
    const std::string &query = given.operands[0], &path = given.operands[1];
    checkOrder(given.operands, input_);
    if (out_.empty()) requireOutside("", path, {query});
    std::optional<AtomicFile> copy;
    if (!out_.empty() &&
        (endingOf(out_) != ".xvm" || (std::filesystem::exists(out_) && !map::isMapFile(out_))))
      throw UsageError(out_ + ": a map ends with .xvm, and only a map is written over");
    if (out_.empty())
      requireWritable(path);
    else
      copy.emplace(out_);
    const map::MapLock lock(path);
    map::SemanticMap map = map::loadMap(path);
    const Job job = inMap(given, map);
    const std::optional<Localization> fix = locate(query, map, job);
    if (!fix) return kNoPose;
    const std::size_t before = map.graph.size();
    Stopwatch watch;
    const map::SemanticMap addition = additionOf(query, fix->T_map_query, map.labels, job);
    sayDoubts(map, path, addition, job.options, job.narrate);
    appendToMap(map, addition, job.options);
    if (copy)
      std::filesystem::copy_file(path, copy->temporaryPath(),
                                 std::filesystem::copy_options::overwrite_existing);
    map::saveRevision(copy ? copy->temporaryPath() : path, map,
                      fmt::format("fused {}, wrong {}", query, chanceWrongText(fix->confidence)));
    if (copy) copy->commit();
    const std::string& changed = copy ? out_ : path;
    job.narrate.stage("fuse", watch.lap_ms(), changed);
    fmt::print("{}: {} vertices, {} before\n", changed, map.graph.size(), before);
    return kDone;
  }

 private:
  static ExitCode undo(const std::string& path) {
    if (!map::undoRevision(path))
      throw Error(path, "nothing to undo: no addition by xview fuse is on record");
    fmt::print("{}: last addition taken back, {} vertices\n", path,
               map::loadMap(path).graph.size());
    return kDone;
  }

  /// Nothing if the query was not accepted.
  std::optional<Localization> locate(const std::string& path, const map::SemanticMap& map,
                                     const Job& job) const {
    if (!job.options.scale.empty())
      throw UsageError("--scale: only what has the lengths of the map can be added to it");
    const QueryInput input = readQuery(path, input_, job, map.labels);
    Stopwatch watch;
    const Localization fix = Localizer(map::borrowed(map), job.options).localize(*input.whole);
    job.narrate.stage("localize", watch.lap_ms(),
                      fmt::format("{}: {}", toString(fix.status), fix.reason));
    if (fix.accepted()) return fix;
    fmt::print("{}: {}, map left as it is: {}\n", printable(path), toString(fix.status),
               printable(fix.reason));
    return std::nullopt;
  }

  /// The query as a map of its own, in the frame of the map.
  map::SemanticMap additionOf(const std::string& path, const Eigen::Isometry3d& T_map_query,
                              const LabelSet& map_labels, const Job& job) const {
    const io::InputOptions input = inputIn(input_, map_labels);
    if (io::recogniseInput(path, input) == io::InputKind::map)
      throw UsageError(path + ": fuse adds recordings and graphs; use xview map --append for maps");
    return mapOf(path, input, job, T_map_query);
  }

  InputFlags input_;
  std::string out_;
  bool undo_ = false;
};

}  // namespace

std::unique_ptr<Command> makeFuse() { return std::make_unique<FuseCommand>(); }

}  // namespace xview::tools
