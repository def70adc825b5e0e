// SPDX-License-Identifier: BSD-3-Clause
#include "base/label_match.h"

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>
#include <utility>

namespace xview {
namespace {

/// What else a kind may be called in a set that is coarser, nearest first: lane markings are part
/// of the road, trunks of the trees. The other way round nothing is known: a tree is no trunk.
/// Ground of one kind does not stand in for another: a verge taken for a road speaks against the
/// right place, one that is left out does not.
std::vector<Kind> standInsFor(Kind kind) {
  static const std::map<Kind, std::vector<Kind>> kStandIns = {
      {Kind::lane_marking, {Kind::road}}, {Kind::fence, {Kind::building}},
      {Kind::trunk, {Kind::vegetation}},  {Kind::pole, {Kind::light, Kind::sign}},
      {Kind::sign, {Kind::pole}},         {Kind::light, {Kind::pole}}};
  const auto found = kStandIns.find(kind);
  return found == kStandIns.end() ? std::vector<Kind>() : found->second;
}

/// "human.pedestrian.adult": adult, pedestrian, human; without words that tell nothing alone.
std::vector<std::string> foldedParts(const std::string& name) {
  static const std::array<std::string, 7> kEmptyWords = {"other", "static", "dynamic", "object",
                                                         "flat",  "misc",   ""};
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= name.size()) {
    const std::size_t end = std::min(name.find('.', begin), name.size());
    const std::string part = foldedName(name.substr(begin, end - begin));
    if (std::find(kEmptyWords.begin(), kEmptyWords.end(), part) == kEmptyWords.end())
      parts.insert(parts.begin(), part);
    begin = end + 1;
  }
  return parts;
}

/// A class with everything that it is compared by.
struct Candidate {
  const ClassInfo* info;
  std::string folded;
  std::vector<std::string> parts;  ///< of a dotted name; else only the whole
  const ClassNames::Line* line;
  bool is_general;  ///< its name is that of its kind

  Candidate(const ClassInfo& known, const ClassNames& names)
      : info(&known),
        folded(foldedName(known.name)),
        parts(foldedParts(known.name)),
        line(names.find(known.name)),
        is_general(std::find(parts.begin(), parts.end(), foldedName(toString(known.kind))) !=
                   parts.end()) {}
};

class PartnerSearch {
 public:
  PartnerSearch(const LabelSet& to, const ClassNames& names) {
    for (const auto& [id, info] : to.classes()) candidates_.emplace_back(info, names);
  }

  std::optional<LabelMatch::Partner> find(const Candidate& a) const {
    if (const auto id = best(a, [&](const Candidate& b) { return b.folded == a.folded; }))
      return LabelMatch::Partner{*id, MatchedBy::name};
    for (const std::string& part : a.parts) {
      const auto has_part = [&](const Candidate& b) {
        return std::find(b.parts.begin(), b.parts.end(), part) != b.parts.end();
      };
      if (const auto id = best(a, has_part)) return LabelMatch::Partner{*id, MatchedBy::name};
    }
    const auto has_line = [&](const Candidate& b) { return a.line && b.line == a.line; };
    if (const auto id = best(a, has_line)) return LabelMatch::Partner{*id, MatchedBy::meaning};
    if (!tellsShape(a.info->kind)) return std::nullopt;
    std::vector<Kind> kinds = standInsFor(a.info->kind);
    kinds.insert(kinds.begin(), a.info->kind);
    for (const Kind kind : kinds) {
      const auto is_kind = [&](const Candidate& b) {
        return b.info->kind == kind && b.info->role != Role::ignored;
      };
      if (const auto id = best(a, is_kind)) return LabelMatch::Partner{*id, MatchedBy::kind};
    }
    return std::nullopt;
  }

 private:
  /// Of those that fit: one of the same kind before others, then of the same role, then the one
  /// that its kind is called after, then the smallest id.
  template <class Fits>
  std::optional<std::uint32_t> best(const Candidate& a, Fits&& fits) const {
    const Candidate* found = nullptr;
    int most = -1;
    for (const Candidate& b : candidates_) {
      const int worth = 4 * int{b.info->kind == a.info->kind} +
                        2 * int{b.info->role == a.info->role} + int{b.is_general};
      if (worth > most && fits(b)) found = &b, most = worth;
    }
    if (!found) return std::nullopt;
    return found->info->id;
  }

  std::vector<Candidate> candidates_;
};

}  // namespace

const char* toString(MatchedBy by) {
  static constexpr const char* kNames[] = {"name", "meaning", "kind"};
  return kNames[static_cast<int>(by)];
}

LabelMatch::LabelMatch(const LabelSet& from, const LabelSet& to, const ClassNames& names)
    : from_(from), to_(to) {
  if (from == to) {
    for (const auto& [id, info] : from.classes()) {
      translated_[id] = id;
      if (info.role != Role::ignored) partners_[id] = {id, MatchedBy::name};
    }
    changes_nothing_ = true;
    return;
  }
  findPartners(names);
  const std::uint32_t ignored = ignoredId();
  changes_nothing_ = alone_.empty();
  for (const auto& [id, info] : from.classes()) {
    const auto partner = partners_.find(id);
    if (partner != partners_.end()) {
      translated_[id] = partner->second.id;
      changes_nothing_ = changes_nothing_ && partner->second.id == id;
    } else if (info.role == Role::ignored) {
      translated_[id] = to.role(id) == Role::ignored ? id : ignored;
      changes_nothing_ = changes_nothing_ && translated_[id] == id;
    } else {
      translated_[id] = freeId();
    }
  }
  unknown_ = freeId();
}

void LabelMatch::findPartners(const ClassNames& names) {
  const PartnerSearch search(to_, names);
  for (const auto& [id, info] : from_.classes()) {
    if (info.role == Role::ignored) continue;
    // What an earlier version of a set called so has its id still.
    const ClassInfo* same = to_.find(id);
    std::optional<Partner> partner;
    if (same && foldedName(same->name) == foldedName(info.name))
      partner = Partner{id, MatchedBy::name};
    else
      partner = search.find(Candidate(info, names));
    if (partner)
      partners_[id] = *partner;
    else
      alone_.push_back(id);
  }
}

std::uint32_t LabelMatch::freeId() {
  while (to_.find(next_free_) || from_.find(next_free_)) --next_free_;
  return next_free_--;
}

std::uint32_t LabelMatch::ignoredId() {
  for (const auto& [id, info] : to_.classes()) {
    if (info.role == Role::ignored) return id;
  }
  return freeId();
}

bool LabelMatch::isHopeless() const {
  const auto may_be_found = [](const ClassInfo& info) {
    return info.role == Role::object || info.role == Role::surface || info.kind == Kind::vehicle;
  };
  for (const auto& [id, partner] : partners_) {
    const ClassInfo* info = to_.find(partner.id);
    if (info && may_be_found(*info)) return false;
  }
  const auto tells = [&](const LabelSet& set) {
    return std::any_of(set.classes().begin(), set.classes().end(),
                       [&](const auto& entry) { return may_be_found(entry.second); });
  };
  return tells(from_) && tells(to_);
}

std::uint32_t LabelMatch::operator()(std::uint32_t id) const {
  const auto found = translated_.find(id);
  if (found != translated_.end()) return found->second;
  return changes_nothing_ || !to_.find(id) ? id : unknown_;
}

std::string LabelMatch::nameOfAlone(std::uint32_t translated_id) const {
  if (changes_nothing_) return {};
  for (const std::uint32_t id : alone_) {
    if (translated_.at(id) == translated_id) return from_.className(id);
  }
  return translated_id == unknown_ ? "ids unknown to its own label set '" + from_.name() + "'" : "";
}

Place translated(Place place, const LabelMatch& match) {
  for (Vertex& vertex : place.graph.vertices) vertex.label = match(vertex.label);
  for (Point& point : place.cloud.points) point.label = match(point.label);
  place.labels = match.to();
  return place;
}

std::string TranslatedRecording::describeUnknown(std::uint32_t label) const {
  const std::string name = match_.nameOfAlone(label);
  if (name.empty()) return ForwardingSource::describeUnknown(label);
  return name + " (no counterpart in label set '" + labels().name() + "')";
}

Frame TranslatedRecording::read(std::size_t index) const {
  Frame frame = ForwardingSource::read(index);
  if (match_.changesNothing()) return frame;
  std::unordered_map<std::uint32_t, std::uint32_t> seen;
  const auto translate = [&](std::uint32_t id) {
    const auto [entry, is_new] = seen.try_emplace(id, 0);
    if (is_new) entry->second = match_(id);
    return entry->second;
  };
  std::uint32_t last = 0, last_translated = translate(0);  // neighbours are mostly of one class
  const auto next = [&](std::uint32_t id) {
    if (id != last) last = id, last_translated = translate(id);
    return last_translated;
  };
  for (std::uint16_t& label : frame.label.pixels) label = static_cast<std::uint16_t>(next(label));
  for (Point& point : frame.cloud.points) point.label = next(point.label);
  return frame;
}

}  // namespace xview
