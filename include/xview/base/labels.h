// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace xview {

/// How a class takes part in localization.
enum class Role : std::uint8_t {
  object,   ///< an object with a place of its own: pole, sign, trunk, lamp
  surface,  ///< continuous: road, facade, hedge; its clusters depend on the view, so it is sampled
  dynamic,  ///< moves between visits: car, person
  ignored   ///< no information: void, sky, noise
};

/// What a class physically is, independent of the data set; chooses the BEV channels it
/// feeds.
enum class Kind : std::uint8_t {
  road,
  sidewalk,
  terrain,
  lane_marking,
  building,
  fence,
  vegetation,
  trunk,
  pole,
  sign,
  light,
  vehicle,
  other_object,
  other_surface,
  none
};

const char* toString(Role role);
const char* toString(Kind kind);
bool isGround(Kind kind);    ///< road, sidewalk, terrain, lane_marking
bool isPoleLike(Kind kind);  ///< pole, sign, light
/// True for kinds that say what a thing looks like, so that two classes of that kind are one:
/// tables and chairs are both other_object and not the same.
bool tellsShape(Kind kind);

struct ClassInfo {
  std::uint32_t id = 0;
  std::string name;
  std::array<std::uint8_t, 3> color{128, 128, 128};  ///< red, green, blue
  Role role = Role::object;
  Kind kind = Kind::other_object;
  bool guessed = false;  ///< role was not given but derived from the name
  bool unknown = false;  ///< guessed from a name that says nothing: the shape may tell more
};

/// The classes of one data set: id <-> name <-> colour, and the role of each.
class LabelSet {
 public:
  LabelSet() = default;
  explicit LabelSet(std::string set_name) : name_(std::move(set_name)) {}

  /// Adds or replaces the class with this id.
  void add(ClassInfo info);

  const std::string& name() const { return name_; }
  bool empty() const { return classes_.empty(); }
  bool isGeneric() const;  ///< made of bare ids by genericLabelSet()
  const std::map<std::uint32_t, ClassInfo>& classes() const { return classes_; }
  const ClassInfo* find(std::uint32_t id) const;                    ///< null if the id is unknown
  Role role(std::uint32_t id) const { return meaningOf(id).role; }  ///< ignored if unknown
  Kind kind(std::uint32_t id) const { return meaningOf(id).kind; }  ///< none if unknown or ignored
  std::string className(std::uint32_t id) const;  ///< "class 17" if the id is unknown
  std::array<std::uint8_t, 3> color(std::uint32_t id) const;

  bool operator==(const LabelSet& other) const;
  bool operator!=(const LabelSet& other) const { return !(*this == other); }

 private:
  /// What is asked for every pixel and point.
  struct Meaning {
    Role role = Role::ignored;
    Kind kind = Kind::none;
  };
  Meaning meaningOf(std::uint32_t id) const {
    return id < meanings_.size() ? meanings_[id] : id < kTabled ? Meaning() : lookUp(id);
  }
  Meaning lookUp(std::uint32_t id) const;

  static constexpr std::uint32_t kTabled = 1 << 16;  ///< ids below are in a table
  std::string name_;
  std::map<std::uint32_t, ClassInfo> classes_;
  std::vector<Meaning> meanings_;
};

/// True if it has a class of which neither its role nor its name tells what it is.
bool hasUnknown(const LabelSet& labels);

/// Unknown classes with the role and kind of the class of that name in another set, if there is
/// one.
LabelSet withRolesOf(const LabelSet& other, const LabelSet& labels);

/// A set for ids of which nothing is known: every id but 0 is an object called "class N"; 0 is
/// ignored.
LabelSet genericLabelSet(const std::vector<std::uint32_t>& ids);

/// A colour that differs well between neighbouring ids.
std::array<std::uint8_t, 3> distinctColor(std::uint32_t id);

/// Synonyms: a table of lines like "object pole: pole, utility pole"
/// (config/class_names.txt, compiled in).
class ClassNames {
 public:
  /// One line of the table.
  struct Line {
    Role role = Role::object;
    Kind kind = Kind::other_object;
    std::vector<std::string> names;  ///< as words; a leading * stands for any beginning of a word
  };

  /// Throws Error that names `source` and the line.
  static ClassNames parse(std::string_view text, const std::string& source);
  /// The table that comes with the program.
  static const ClassNames& shipped();

  /// The first line that fits; null if there is none.
  const Line* find(const std::string& class_name) const;
  /// The same table with these lines asked first.
  ClassNames extendedBy(const ClassNames& own) const;
  Role role(const std::string& class_name) const;  ///< object if no line fits
  Kind kind(const std::string& class_name) const;  ///< other_object if no line fits

 private:
  std::vector<Line> lines_;
};

/// Letters and digits in lower case without a plural s, so that two spellings of one name are the
/// same: "Traffic_Signs", "traffic-sign" and "TrafficSign" are "trafficsign".
std::string foldedName(const std::string& name);

}  // namespace xview
