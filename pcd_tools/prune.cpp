// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <map>
#include <optional>

#include "base/label_match.h"
#include "base/user_text.h"
#include "compare/changes.h"
#include "compare/self_similarity.h"
#include "inputs.h"
#include "map_changes.h"
#include "outputs.h"
#include "tool.h"
#include "xview/base/error.h"
#include "xview/base/localization.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {
namespace {

/// On how many visits a vertex should have been seen and was not, since the last one that saw it.
class Absences {
 public:
  explicit Absences(std::size_t vertices) : missed_(vertices) {}

  void add(const std::vector<Presence>& presence) {
    for (std::size_t i = 0; i < missed_.size(); ++i) {
      if (presence[i] == Presence::gone) ++missed_[i];
      if (presence[i] == Presence::stands) missed_[i] = 0;
    }
  }
  std::vector<std::size_t> atLeast(int visits) const {
    std::vector<std::size_t> vertices;
    for (std::size_t i = 0; i < missed_.size(); ++i) {
      if (missed_[i] >= visits) vertices.push_back(i);
    }
    return vertices;
  }

 private:
  std::vector<int> missed_;
};

class PruneCommand final : public Command {
 public:
  Description describe() const override {
    return {"prune",
            "MAP",
            "forget what stands no more",
            "A thing is forgotten if the last visits have looked where it stood and did not see "
            "it, since the last one that did. Visits are what xview fuse, map --append and map "
            "--join have added; xview info lists them. What nobody looked at stays. `xview map MAP "
            "--undo` takes it back.",
            "xview prune town.xvm --absent 2",
            1,
            1};
  }

  void declare(Flags& flags) override {
    flags.add("--absent", absent_, "visits that did not see it");
    flags.addOutput("-o,--out", out_, "write the map to this file and leave MAP alone");
  }

  ExitCode run(const Job& given) override {
    if (absent_ < 1) throw UsageError(fmt::format("--absent = {}, must be >= 1", absent_));
    const std::string& path = given.operands.front();
    const std::string& target = out_.empty() ? path : out_;
    requireWritable(target);
    const map::MapLock lock(path);
    map::SemanticMap map = map::unpacked(map::openMap(path));
    const Job job = inMap(given, map);
    Stopwatch watch;
    const std::vector<std::size_t> gone = absencesIn(path, map).atLeast(absent_);
    const std::size_t before = map.graph.size();
    const std::string names = namesOf(map, gone);
    if (!gone.empty() || target != path) {
      MapDraft draft(target, path);
      if (!gone.empty()) {
        removeObjects(map, gone);
        measureNullHypothesis(map, job.options);
        draft.change(map, fmt::format("pruned {} of {} things: {}", gone.size(), before, names));
      }
      draft.commit();
    }
    job.narrate.stage("prune", watch.lap_ms(), target);
    fmt::print("{}: {} of {} things forgotten{}{}\n", target, gone.size(), before,
               gone.empty() ? "" : ": ", printable(names));
    return kDone;
  }

 private:
  Absences absencesIn(const std::string& path, const map::SemanticMap& map) const {
    const std::vector<map::Revision> revisions = map::readRevisions(path);
    Absences absences(map.graph.size());
    int visits = 0;
    for (std::size_t i = 0; i < revisions.size(); ++i) {
      if (!revisions[i].is_visit) continue;
      map::Visit visit = map::loadVisit(path, i);
      ++visits;
      const LabelMatch match(visit.place.labels, map.labels);
      const Place seen = translated(std::move(visit.place), match);
      absences.add(findChanges(map, seen, Eigen::Isometry3d::Identity(), visit.sigma_m).presence);
    }
    if (visits < absent_)
      throw Error(path, fmt::format("has {} visits on record, and --absent asks for {}; xview fuse "
                                    "and xview map --append add some",
                                    visits, absent_));
    return absences;
  }

  /// "2 pole, 1 trunk"
  static std::string namesOf(const map::SemanticMap& map, const std::vector<std::size_t>& gone) {
    std::map<std::string, std::size_t> counts;
    for (const std::size_t i : gone) ++counts[map.labels.className(map.graph.vertices[i].label)];
    std::string text;
    for (const auto& [name, count] : counts)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name);
    return text;
  }

  std::string out_;
  int absent_ = 2;
};

}  // namespace

std::unique_ptr<Command> makePrune() { return std::make_unique<PruneCommand>(); }

}  // namespace xview::tools
