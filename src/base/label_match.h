// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/labels.h"
#include "xview/base/semantic_place.h"

namespace xview {

/// Why two classes are taken for the same.
enum class MatchedBy {
  name,     ///< their names, or parts of dotted ones, agree but for spelling
  meaning,  ///< one line of ClassNames has both
  kind      ///< they are of one kind, or of kinds that stand for one another
};
const char* toString(MatchedBy by);

/// Which class of another label set each class of a set is. Ids mean nothing between two sets,
/// unless neither has names.
class LabelMatch {
 public:
  struct Partner {
    std::uint32_t id = 0;  ///< of the class in the other set
    MatchedBy by = MatchedBy::name;
  };

  LabelMatch(const LabelSet& from, const LabelSet& to,
             const ClassNames& names = ClassNames::shipped());

  const LabelSet& from() const { return from_; }
  const LabelSet& to() const { return to_; }
  /// By id; classes that are ignored need no partner and are not here.
  const std::map<std::uint32_t, Partner>& partners() const { return partners_; }
  /// Ids of classes that are not ignored and have no partner.
  const std::vector<std::uint32_t>& alone() const { return alone_; }
  /// True if every id stays what it is.
  bool changesNothing() const { return changes_nothing_; }
  /// True if both sets tell something, but no class that may be found again has a partner.
  bool isHopeless() const;

  /// The id in the other set: of the partner, or one that is ignored there. Each class without a
  /// partner has an id of its own, unknown to the other set; ids that were unknown stay unknown.
  std::uint32_t operator()(std::uint32_t id) const;
  /// What an id that operator() returned was, if it was a class without a partner; else empty.
  std::string nameOfAlone(std::uint32_t translated_id) const;

 private:
  void findPartners(const ClassNames& names);
  std::uint32_t freeId();
  std::uint32_t ignoredId();

  LabelSet from_, to_;
  std::map<std::uint32_t, Partner> partners_;
  std::vector<std::uint32_t> alone_;
  std::map<std::uint32_t, std::uint32_t> translated_;  ///< of all classes of the set
  std::uint32_t unknown_ = 0;                          ///< for unknown ids that the other set knows
  std::uint32_t next_free_ = 0xFFFF;                   ///< label images have 16 bits
  bool changes_nothing_ = false;
};

/// The place in the classes of the other set. All vertices and points stay; those without a partner
/// have labels that the other set does not know.
Place translated(Place place, const LabelMatch& match);

/// The same frames in the classes of another set.
class TranslatedRecording final : public ForwardingSource {
 public:
  /// `source`: as of a ForwardingSource.
  template <class Source>
  TranslatedRecording(Source&& source, LabelMatch match)
      : ForwardingSource(std::forward<Source>(source)), match_(std::move(match)) {}

  Frame read(std::size_t index) const override;
  const LabelSet& labels() const override { return match_.to(); }
  const FrameSource& asMeasured() const override { return source_.asMeasured(); }
  std::string describeUnknown(std::uint32_t label) const override;

 private:
  LabelMatch match_;
};

}  // namespace xview
