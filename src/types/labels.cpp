// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/labels.h"

#include <algorithm>
#include <cctype>

namespace xview {
namespace {

constexpr const char* kGenericName = "generic";

struct NameRule {
  const char* word;  ///< the name contains it, as a whole word or (with a leading *) anywhere
  Role role;
  Kind kind;
};

// First rule that fits wins: the specific before the general ("traffic light" before "light",
// "wall" before "building").
constexpr NameRule kRules[] = {
    {"void", Role::ignored, Kind::none},
    {"unlabeled", Role::ignored, Kind::none},
    {"unlabelled", Role::ignored, Kind::none},
    {"unknown", Role::ignored, Kind::none},
    {"none", Role::ignored, Kind::none},
    {"outlier", Role::ignored, Kind::none},
    {"noise", Role::ignored, Kind::none},
    {"sky", Role::ignored, Kind::none},
    {"reserved", Role::ignored, Kind::none},
    {"out of roi", Role::ignored, Kind::none},
    {"ego", Role::ignored, Kind::none},
    {"rectification", Role::ignored, Kind::none},
    {"ignore", Role::ignored, Kind::none},
    {"water", Role::ignored, Kind::none},
    {"undefined", Role::ignored, Kind::none},
    {"unclassified", Role::ignored, Kind::none},
    {"misc", Role::ignored, Kind::none},
    {"river", Role::ignored, Kind::none},
    {"sea", Role::ignored, Kind::none},
    {"artefact", Role::ignored, Kind::none},
    {"artifact", Role::ignored, Kind::none},

    {"moving", Role::dynamic, Kind::none},
    {"bicycle rack", Role::object, Kind::other_object},
    {"bicycle parking", Role::object, Kind::other_object},
    {"post box", Role::object, Kind::other_object},
    {"bike lane", Role::surface, Kind::road},
    {"service lane", Role::surface, Kind::road},
    {"bus stop", Role::object, Kind::other_object},
    {"parking meter", Role::object, Kind::other_object},
    {"person", Role::dynamic, Kind::none},
    {"people", Role::dynamic, Kind::none},
    {"pedestrian", Role::dynamic, Kind::none},
    {"human", Role::dynamic, Kind::none},
    {"rider", Role::dynamic, Kind::none},
    {"*cyclist", Role::dynamic, Kind::none},
    {"animal", Role::dynamic, Kind::none},
    {"dynamic", Role::dynamic, Kind::none},
    {"bicycle", Role::dynamic, Kind::none},
    {"bike", Role::dynamic, Kind::none},
    {"motorcycle", Role::dynamic, Kind::none},
    {"two wheeler", Role::dynamic, Kind::none},
    {"car", Role::dynamic, Kind::vehicle},
    {"truck", Role::dynamic, Kind::vehicle},
    {"bus", Role::dynamic, Kind::vehicle},
    {"van", Role::dynamic, Kind::vehicle},
    {"caravan", Role::dynamic, Kind::vehicle},
    {"trailer", Role::dynamic, Kind::vehicle},
    {"train", Role::dynamic, Kind::vehicle},
    {"on rails", Role::dynamic, Kind::vehicle},
    {"tram", Role::dynamic, Kind::vehicle},
    {"boat", Role::dynamic, Kind::vehicle},
    {"vehicle", Role::dynamic, Kind::vehicle},
    {"trafficcone", Role::dynamic, Kind::none},
    {"traffic cone", Role::dynamic, Kind::none},
    {"stroller", Role::dynamic, Kind::none},
    {"wheelchair", Role::dynamic, Kind::none},

    {"lane", Role::surface, Kind::lane_marking},
    {"lanemarking", Role::surface, Kind::lane_marking},
    {"road line", Role::surface, Kind::lane_marking},
    {"roadline", Role::surface, Kind::lane_marking},
    {"road marking", Role::surface, Kind::lane_marking},
    {"crosswalk", Role::surface, Kind::lane_marking},

    {"traffic light", Role::object, Kind::light},
    {"trafficlight", Role::object, Kind::light},
    {"traffic signal", Role::object, Kind::light},
    {"traffic signals", Role::object, Kind::light},
    {"street light", Role::object, Kind::light},
    {"streetlight", Role::object, Kind::light},
    {"street lamp", Role::object, Kind::light},
    {"lamp", Role::object, Kind::light},
    {"traffic sign", Role::object, Kind::sign},
    {"trafficsign", Role::object, Kind::sign},
    {"sign", Role::object, Kind::sign},
    {"signboard", Role::object, Kind::sign},
    {"give way", Role::object, Kind::sign},
    {"pole", Role::object, Kind::pole},
    {"poles", Role::object, Kind::pole},
    {"polegroup", Role::object, Kind::pole},
    {"smallpole", Role::object, Kind::pole},
    {"bollard", Role::object, Kind::pole},
    {"post", Role::object, Kind::pole},
    {"pillar", Role::object, Kind::pole},
    {"column", Role::object, Kind::pole},
    {"mast", Role::object, Kind::pole},
    {"street furniture", Role::object, Kind::other_object},
    {"trunk", Role::object, Kind::trunk},
    {"tree trunk", Role::object, Kind::trunk},

    {"sidewalk", Role::surface, Kind::sidewalk},
    {"pavement", Role::surface, Kind::sidewalk},
    {"footpath", Role::surface, Kind::sidewalk},
    {"curb", Role::surface, Kind::sidewalk},
    {"road", Role::surface, Kind::road},
    {"street", Role::surface, Kind::road},
    {"parking", Role::surface, Kind::road},
    {"driveable surface", Role::surface, Kind::road},
    {"drivable surface", Role::surface, Kind::road},
    {"runway", Role::surface, Kind::road},
    {"asphalt", Role::surface, Kind::road},
    {"rail track", Role::surface, Kind::road},
    {"terrain", Role::surface, Kind::terrain},
    {"grass", Role::surface, Kind::terrain},
    {"ground", Role::surface, Kind::terrain},
    {"floor", Role::surface, Kind::terrain},
    {"soil", Role::surface, Kind::terrain},
    {"dirt", Role::surface, Kind::terrain},
    {"earth", Role::surface, Kind::terrain},
    {"sand", Role::surface, Kind::terrain},
    {"flat", Role::surface, Kind::terrain},
    {"field", Role::surface, Kind::terrain},
    {"gravel", Role::surface, Kind::terrain},
    {"mud", Role::surface, Kind::terrain},
    {"snow", Role::surface, Kind::terrain},
    {"hill", Role::surface, Kind::terrain},
    {"mountain", Role::surface, Kind::terrain},

    {"hedge", Role::surface, Kind::vegetation},
    {"bush", Role::surface, Kind::vegetation},
    {"vegetation", Role::surface, Kind::vegetation},
    {"plants", Role::surface, Kind::vegetation},
    {"plant", Role::surface, Kind::vegetation},
    {"shrub", Role::surface, Kind::vegetation},
    {"palm", Role::object, Kind::vegetation},
    {"tree", Role::object, Kind::vegetation},
    {"trees", Role::object, Kind::vegetation},
    {"fence", Role::surface, Kind::fence},
    {"guard rail", Role::surface, Kind::fence},
    {"guardrail", Role::surface, Kind::fence},
    {"railing", Role::surface, Kind::fence},
    {"barrier", Role::surface, Kind::fence},
    {"gate", Role::surface, Kind::fence},
    {"wall", Role::surface, Kind::building},
    {"building", Role::surface, Kind::building},
    {"house", Role::surface, Kind::building},
    {"skyscraper", Role::surface, Kind::building},
    {"garage", Role::surface, Kind::building},
    {"manmade", Role::surface, Kind::building},
    {"facade", Role::surface, Kind::building},
    {"roof", Role::surface, Kind::building},
    {"window", Role::surface, Kind::building},
    {"door", Role::surface, Kind::building},
    {"bridge", Role::surface, Kind::building},
    {"tunnel", Role::surface, Kind::building},
    {"structure", Role::surface, Kind::other_surface},
    {"ceiling", Role::surface, Kind::other_surface},
};

/// Lower case, everything but letters and digits becomes one blank, blanks at both ends. With
/// `split_humps` "TrafficSign" becomes two words, else one.
std::string asWords(const std::string& name, bool split_humps) {
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

const NameRule* findRule(const std::string& name) {
  const std::string joined = asWords(name, false), split = asWords(name, true);
  const std::string spellings[] = {joined, split, inSingular(joined), inSingular(split)};
  for (const NameRule& rule : kRules) {
    const bool anywhere = rule.word[0] == '*';
    const std::string needle =
        anywhere ? std::string(rule.word + 1) : " " + std::string(rule.word) + " ";
    for (const std::string& words : spellings) {
      if (words.find(needle) != std::string::npos) return &rule;
    }
  }
  return nullptr;
}

}  // namespace

const char* toString(Role role) {
  switch (role) {
    case Role::object:
      return "object";
    case Role::surface:
      return "surface";
    case Role::dynamic:
      return "dynamic";
    case Role::ignored:
      return "ignored";
  }
  return "?";
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

Role guessRole(const std::string& name) {
  const NameRule* rule = findRule(name);
  return rule ? rule->role : Role::object;
}

Kind guessKind(const std::string& name) {
  const NameRule* rule = findRule(name);
  return rule ? rule->kind : Kind::other_object;
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
    set.add(info);
  }
  return set;
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

}  // namespace xview
