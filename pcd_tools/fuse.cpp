// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <optional>

#include "answer_table.h"
#include "base/user_text.h"
#include "consistency_checks.h"
#include "inputs.h"
#include "map/contents.h"
#include "map_changes.h"
#include "outputs.h"
#include "placed_visit.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"

namespace xview::tools {
namespace {

class FuseCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "fuse",
        "QUERY MAP",
        "add an accepted query to the map (undo with --undo)",
        "The query is localized by stretches of some 60 m; what is accepted is brought into the "
        "map frame, frame by frame, because odometry drifts, and added. If nothing is, the map "
        "stays as it is (exit code 3). Either all of it happens or nothing. `xview fuse MAP "
        "--undo` takes the last change back.",
        "xview fuse town/rear town.xvm",
        1,
        2};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    verdict_.declare(flags);
    flags.add("--undo", undo_, "take back the last change of MAP");
    flags.add("--force", force_, "add also what contradicts the map or is in it already");
    flags.addOutput("-o,--out", out_, "write the larger map to this file and leave MAP alone");
  }

  ExitCode run(const Job& given) override {
    if (undo_) {
      if (!out_.empty()) throw UsageError("--undo changes MAP itself, without -o");
      return undoLast(given.operands.back());
    }
    if (given.operands.size() != 2) throw UsageError("xview fuse needs QUERY MAP, found 1 operand");
    if (!given.options.scale.empty())
      throw UsageError("--scale: only what has the lengths of the map can be added to it");
    const std::string &query = given.operands[0], &path = given.operands[1];
    checkOrder(given.operands, input_);
    if (out_.empty()) requireOutside("", path, {query});
    const std::string& target = out_.empty() ? path : out_;
    requireWritable(target);
    const map::MapLock lock(path);
    MapDraft draft(target, path);
    map::SemanticMap map = map::openMap(path);
    Job job = inMap(given, map);
    verdict_.applyTo(job);
    Stopwatch watch;
    QueryInput input = openQuery(query, input_, job, map.labels);
    std::string refusal;
    const auto placed =
        placeVisit(input, Localizer(map::borrowed(map), job.options, input_.parsed().class_names),
                   job, refusal);
    job.narrate.stage("localize", watch.lap_ms(), placed ? placed->how : refusal);
    if (!placed) {
      fmt::print("{}: not found, map left as it is: {}\n", printable(query), printable(refusal));
      return kNoPose;
    }
    const std::size_t before = map::countsOf(map).vertices;
    const map::Visit visit = additionOf(*placed, input, input_, map, job);
    if (!force_) requireFits(map, path, visit.place, job);
    appendToMap(map, visit.place, job.options);
    draft.add(map, fmt::format("fused {}, wrong {}", query, chanceWrongText(placed->confidence)),
              visit);
    draft.commit();
    job.narrate.stage("fuse", watch.lap_ms(), target);
    fmt::print("{}: {} vertices, {} before\n", target, map::countsOf(map).vertices, before);
    return kDone;
  }

 private:
  InputFlags input_;
  VerdictFlags verdict_;
  std::string out_;
  bool undo_ = false, force_ = false;
};

}  // namespace

std::unique_ptr<Command> makeFuse() { return std::make_unique<FuseCommand>(); }

}  // namespace xview::tools
