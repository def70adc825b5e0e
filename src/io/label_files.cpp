// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/label_files.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "base/user_text.h"
#include "input_file.h"
#include "shipped_labels.h"
#include "xview/base/error.h"
#include "xview/io/recording.h"
#include "yaml_file.h"

namespace xview::io {
namespace {

const std::vector<std::string> kClassKeys = {"id", "name", "color", "role", "kind", "static"};

/// The enumerator with this name, of those from 0 to `last`.
template <class Enum>
Enum parseName(const YamlFile& file, const YAML::Node& node, const std::string& what, Enum last) {
  const std::string name = file.text(node, what);
  std::string known;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    const auto value = static_cast<Enum>(i);
    if (name == toString(value)) return value;
    known += (i == 0 ? "" : ", ") + std::string(toString(value));
  }
  file.fail(node, what + ": expected one of " + known + ", found '" + name + "'");
}

std::array<std::uint8_t, 3> parseColor(const YamlFile& file, const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 3) file.fail(node, "color: expected [red, green, blue]");
  std::array<std::uint8_t, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    color[i] = static_cast<std::uint8_t>(file.integer(node[i], "color", 0, 255));
  }
  return color;
}

/// A guess of the role, corrected by what the file says about motion: what is not static is
/// dynamic, unless it is nothing.
Role correctedRole(Role guess, std::optional<bool> is_static) {
  if (!is_static || guess == Role::ignored) return guess;
  if (!*is_static) return Role::dynamic;
  return guess == Role::dynamic ? Role::object : guess;
}

/// A guess of the kind that does not contradict the role.
Kind kindFor(Role role, Kind guess) {
  switch (role) {
    case Role::object:
      return guess == Kind::none || guess == Kind::other_surface ? Kind::other_object : guess;
    case Role::surface:
      return guess == Kind::none || guess == Kind::other_object ? Kind::other_surface : guess;
    case Role::dynamic:
      return guess == Kind::vehicle ? Kind::vehicle : Kind::none;
    case Role::ignored:
      break;
  }
  return Kind::none;
}

ClassInfo parseClass(const YamlFile& file, const YAML::Node& node, const ClassNames& names) {
  file.requireKeys(node, kClassKeys);
  if (!node["id"] || !node["name"]) file.fail(node, "a class needs id and name");
  ClassInfo info;
  info.id = static_cast<std::uint32_t>(file.integer(node["id"], "id", 0, 0xFFFFFFFF));
  info.name = file.text(node["name"], "name");
  info.color = node["color"] ? parseColor(file, node["color"]) : distinctColor(info.id);
  std::optional<bool> is_static;
  if (node["static"]) is_static = file.boolean(node["static"], "static");
  info.guessed = !node["role"];
  info.role = info.guessed ? correctedRole(names.role(info.name), is_static)
                           : parseName(file, node["role"], "role", Role::ignored);
  info.kind = node["kind"] ? parseName(file, node["kind"], "kind", Kind::none)
                           : kindFor(info.role, names.kind(info.name));
  info.unknown = info.guessed && !is_static && !node["kind"] && !names.find(info.name);
  return info;
}

LabelSet parseLabelSet(const YamlFile& file, const std::string& fallback_name,
                       const ClassNames& names) {
  const YAML::Node root = file.root();
  const bool bare = root.IsSequence();
  if (!bare) {
    if (root.IsNull()) file.fail(root, "the file is empty, expected classes");
    file.requireKeys(root, {"name", "classes"});
  }
  const YAML::Node classes = bare ? root : root["classes"];
  if (!classes || !classes.IsSequence() || classes.size() == 0) {
    file.fail(root, "expected a list of classes: - {id: 1, name: pole}");
  }
  const bool named = !bare && root["name"];
  LabelSet set(named ? file.text(root["name"], "name") : fallback_name);
  for (const YAML::Node& node : classes) {
    const ClassInfo info = parseClass(file, node, names);
    if (set.find(info.id)) file.fail(node, fmt::format("id {} a second time", info.id));
    set.add(info);
  }
  return set;
}

}  // namespace

LabelSet readLabelSet(const std::string& path, const ClassNames& names) {
  return parseLabelSet(YamlFile::read(path), std::filesystem::path(path).filename().string(),
                       names);
}

std::vector<std::string> shippedLabelSets() {
  std::vector<std::string> names;
  for (const ShippedLabels& set : kShippedLabels) names.emplace_back(set.name);
  return names;
}

LabelSet shippedLabelSet(const std::string& name) {
  for (const ShippedLabels& set : kShippedLabels) {
    if (name == set.name)
      return parseLabelSet(YamlFile::parse(name + ".yaml", set.yaml), name, ClassNames::shipped());
  }
  const std::filesystem::path path(name);
  if (path.has_parent_path() || path.has_extension())
    throw UsageError("label set '" + name + "': no such file");
  throw UsageError("unknown label set '" + name + "'" + knownWordsHint(name, shippedLabelSets()));
}

std::optional<LabelSet> namedLabels(const InputOptions& options, const std::string& folder,
                                    const std::optional<LabelSet>& own) {
  const std::string& chosen = options.labels;
  if (!chosen.empty()) {
    const std::vector<std::string> shipped = shippedLabelSets();
    const bool is_shipped = std::find(shipped.begin(), shipped.end(), chosen) != shipped.end();
    const bool is_file = !is_shipped && std::filesystem::exists(chosen);
    return is_file ? readLabelSet(chosen, options.class_names) : shippedLabelSet(chosen);
  }
  if (own) return own;
  const std::filesystem::path beside = std::filesystem::path(folder) / "classes.yaml";
  if (std::filesystem::exists(beside)) return readLabelSet(beside.string(), options.class_names);
  return std::nullopt;
}

ClassNames readClassNames(const std::string& path) {
  InputFile file(path);
  std::string text;
  std::string_view line;
  while (file.readLine(line)) text += std::string(line) + "\n";
  return ClassNames::shipped().extendedBy(ClassNames::parse(text, path));
}

}  // namespace xview::io
