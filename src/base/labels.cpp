// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/labels.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "base/user_text.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr const char* kGenericName = "generic";

}  // namespace

const char* toString(Role role) {
  static constexpr const char* kNames[] = {"object", "surface", "dynamic", "ignored"};
  return role <= Role::ignored ? kNames[static_cast<int>(role)] : "?";
}

const char* toString(Kind kind) {
  static constexpr const char* kNames[] = {
      "road",  "sidewalk",   "terrain",      "lane_marking",  "building",
      "fence", "vegetation", "trunk",        "pole",          "sign",
      "light", "vehicle",    "other_object", "other_surface", "none"};
  return kind <= Kind::none ? kNames[static_cast<int>(kind)] : "?";
}

bool isGround(Kind kind) { return kind <= Kind::lane_marking; }
bool isPoleLike(Kind kind) {
  return kind == Kind::pole || kind == Kind::sign || kind == Kind::light;
}
bool tellsShape(Kind kind) { return kind < Kind::other_object; }

bool LabelSet::isGeneric() const { return name_ == kGenericName; }

void LabelSet::add(ClassInfo info) {
  const std::uint32_t id = info.id;
  classes_[id] = std::move(info);
  if (id >= kTabled) return;
  if (id >= meanings_.size()) meanings_.resize(id + 1);
  meanings_[id] = lookUp(id);
}

const ClassInfo* LabelSet::find(std::uint32_t id) const {
  const auto it = classes_.find(id);
  return it == classes_.end() ? nullptr : &it->second;
}

LabelSet::Meaning LabelSet::lookUp(std::uint32_t id) const {
  const ClassInfo* info = find(id);
  if (!info || info->role == Role::ignored) return {};
  return {info->role, info->kind};
}

std::string LabelSet::className(std::uint32_t id) const {
  const ClassInfo* info = find(id);
  return info ? info->name : "class " + std::to_string(id);
}

std::array<std::uint8_t, 3> LabelSet::color(std::uint32_t id) const {
  const ClassInfo* info = find(id);
  return info ? info->color : distinctColor(id);
}

bool LabelSet::operator==(const LabelSet& other) const {
  return std::equal(classes_.begin(), classes_.end(), other.classes_.begin(), other.classes_.end(),
                    [](const auto& a, const auto& b) {
                      return a.first == b.first && a.second.name == b.second.name &&
                             a.second.role == b.second.role;
                    });
}

LabelSet genericLabelSet(const std::vector<std::uint32_t>& ids) {
  LabelSet set(kGenericName);
  for (const std::uint32_t id : ids) {
    ClassInfo info;
    info.id = id;
    info.name = id == 0 ? "unlabelled" : "class " + std::to_string(id);
    info.color = distinctColor(id);
    info.role = id == 0 ? Role::ignored : Role::object;
    info.kind = id == 0 ? Kind::none : Kind::other_object;
    info.guessed = true;
    info.unknown = id != 0;
    set.add(info);
  }
  return set;
}

bool hasUnknown(const LabelSet& labels) {
  const auto& classes = labels.classes();
  return std::any_of(classes.begin(), classes.end(),
                     [](const auto& entry) { return entry.second.unknown; });
}

LabelSet withRolesOf(const LabelSet& other, const LabelSet& labels) {
  std::map<std::string, const ClassInfo*> named;
  for (const auto& [id, info] : other.classes()) named.emplace(foldedName(info.name), &info);
  LabelSet result = labels;
  for (const auto& [id, info] : labels.classes()) {
    const auto found = named.find(foldedName(info.name));
    if (!info.unknown || found == named.end()) continue;
    ClassInfo told = info;
    told.role = found->second->role;
    told.kind = found->second->kind;
    told.unknown = false;
    result.add(told);
  }
  return result;
}

std::array<std::uint8_t, 3> distinctColor(std::uint32_t id) {
  // Hues a golden angle apart, three levels of brightness.
  const double hue = 6.0 * (static_cast<double>((id * 2654435769u) >> 8) / 16777216.0);
  const double value = 255.0 - 45.0 * (id % 3);
  const int sector = static_cast<int>(hue);
  const double rise = hue - sector, low = 0.25;
  const double up = low + (1 - low) * rise, down = 1 - (1 - low) * rise;
  const double table[6][3] = {{1, up, low},   {down, 1, low}, {low, 1, up},
                              {low, down, 1}, {up, low, 1},   {1, low, down}};
  std::array<std::uint8_t, 3> rgb{};
  for (int c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(value * table[sector % 6][c]);
  return rgb;
}

/// Contents of config/class_names.txt, compiled in.
extern const char* const kShippedClassNames;

namespace {

/// Lower case, everything but letters and digits becomes one blank, blanks at both ends. With
/// `split_humps` "TrafficSign" becomes two words, else one.
std::string asWords(std::string_view name, bool split_humps) {
  std::string words = " ";
  bool after_small = false;
  for (const char letter : name) {
    const auto c = static_cast<unsigned char>(letter);
    const bool hump = split_humps && after_small && std::isupper(c);
    if ((hump || !std::isalnum(c)) && words.back() != ' ') words += ' ';
    if (std::isalnum(c)) words += static_cast<char>(std::tolower(c));
    after_small = std::islower(c) != 0;
  }
  if (words.back() != ' ') words += ' ';
  return words;
}

/// Every word without a final s ("roads" -> "road"), which leaves "grass" and "bus" to the other
/// spelling.
std::string inSingular(const std::string& words) {
  std::string singular;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool final_s = words[i] == 's' && words[i + 1] == ' ' && words[i - 1] != 's';
    if (!final_s) singular += words[i];
  }
  return singular;
}

std::string_view trimmed(std::string_view text) {
  constexpr const char* kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The part of the text before the separator, which is taken off with it.
std::string_view takeUntil(std::string_view& text, char separator) {
  const std::size_t end = text.find(separator);
  const std::string_view part = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  return part;
}

/// Nothing if it is not as a line should be.
std::optional<ClassNames::Line> parseLine(std::string_view text) {
  std::string_view names = text;
  std::string_view meaning = trimmed(takeUntil(names, ':'));
  const auto role = enumeratorNamed(trimmed(takeUntil(meaning, ' ')), Role::ignored);
  const auto kind = enumeratorNamed(trimmed(meaning), Kind::none);
  if (!role || !kind) return std::nullopt;
  ClassNames::Line line{*role, *kind, {}};
  while (!names.empty()) {
    const std::string_view name = trimmed(takeUntil(names, ','));
    if (name.empty()) return std::nullopt;
    const bool anywhere = name[0] == '*';
    const std::string words = asWords(name, false);
    line.names.push_back(anywhere ? words.substr(1) : words);
  }
  if (line.names.empty()) return std::nullopt;
  return line;
}

}  // namespace

ClassNames ClassNames::parse(std::string_view text, const std::string& source) {
  ClassNames table;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = takeUntil(text, '\n');
    line = trimmed(takeUntil(line, '#'));
    if (line.empty()) continue;
    const auto parsed = parseLine(line);
    if (!parsed) {
      throw Error(source + ":" + std::to_string(number),
                  "expected 'role kind: name, name' with a role (object, surface, dynamic, "
                  "ignored) and a kind (road, pole, other_object, ...), found '" +
                      std::string(line.substr(0, 60)) + "'");
    }
    table.lines_.push_back(*parsed);
  }
  return table;
}

const ClassNames& ClassNames::shipped() {
  static const ClassNames table = parse(kShippedClassNames, "built-in class names");
  return table;
}

const ClassNames::Line* ClassNames::find(const std::string& class_name) const {
  const std::string joined = asWords(class_name, false), split = asWords(class_name, true);
  std::vector<std::string> spellings = {joined, split, inSingular(joined), inSingular(split)};
  std::sort(spellings.begin(), spellings.end());  // most names have one spelling only
  spellings.erase(std::unique(spellings.begin(), spellings.end()), spellings.end());
  const auto fits = [&](const std::string& name) {
    return std::any_of(spellings.begin(), spellings.end(), [&](const std::string& words) {
      return words.find(name) != std::string::npos;
    });
  };
  const auto line = std::find_if(lines_.begin(), lines_.end(), [&](const Line& l) {
    return std::any_of(l.names.begin(), l.names.end(), fits);
  });
  return line == lines_.end() ? nullptr : &*line;
}

ClassNames ClassNames::extendedBy(const ClassNames& own) const {
  ClassNames both = own;
  both.lines_.insert(both.lines_.end(), lines_.begin(), lines_.end());
  return both;
}

Role ClassNames::role(const std::string& class_name) const {
  const Line* line = find(class_name);
  return line ? line->role : Role::object;
}

Kind ClassNames::kind(const std::string& class_name) const {
  const Line* line = find(class_name);
  return line ? line->kind : Kind::other_object;
}

std::string foldedName(const std::string& name) {
  std::string folded = inSingular(asWords(name, true));
  folded.erase(std::remove(folded.begin(), folded.end(), ' '), folded.end());
  return folded;
}

}  // namespace xview
