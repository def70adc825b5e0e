// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/labels.h"

#include <algorithm>

namespace xview {
namespace {

constexpr const char* kGenericName = "generic";

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
