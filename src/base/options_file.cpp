// SPDX-License-Identifier: BSD-3-Clause
#include "xview/options.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <variant>

#include "base/option_field.h"
#include "base/option_visits.h"
#include "shipped_config.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// The word may be meant for a key or, in a file, for a group of them.
std::string unknownKey(const std::string& key, const std::vector<OptionField>& fields) {
  std::vector<std::string> known;
  for (const OptionField& field : fields) {
    known.push_back(field.key);
    const std::string group = field.key.substr(0, field.key.find('.'));
    if (group != field.key) known.push_back(group);
  }
  return "unknown option " + key + knownWordsHint(key, known);
}

const OptionField* findField(const std::vector<OptionField>& fields, const std::string& key) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const OptionField& field) { return field.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

bool isGroup(const std::vector<OptionField>& fields, const std::string& key) {
  return std::any_of(fields.begin(), fields.end(), [&](const OptionField& field) {
    return field.key.compare(0, key.size() + 1, key + ".") == 0;
  });
}

/// Applies the nodes of one file to the options, with path:line before everything that is wrong.
class FileReader {
 public:
  FileReader(Options& options, const std::string& path) : path_(path), fields_(fieldsOf(options)) {}

  void apply(const YAML::Node& node, const std::string& prefix) {
    if (!node.IsMap()) fail(node, "expected `key: value` lines");
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) fail(entry.first, "expected the name of an option");
      applyEntry(prefix + entry.first.Scalar(), entry.first, entry.second);
    }
  }

 private:
  void applyEntry(const std::string& key, const YAML::Node& name, const YAML::Node& value) {
    if (!seen_.insert(key).second) fail(name, key + " is given a second time");
    if (const OptionField* field = findField(fields_, key)) {
      if (!value.IsScalar()) fail(name, key + " needs one value");
      assignAt(value, *field);
    } else if (!isGroup(fields_, key)) {
      fail(name, unknownKey(key, fields_));
    } else if (value.IsMap()) {
      apply(value, key + ".");
    } else if (!value.IsNull()) {
      fail(name, key + " is a group of options, expected `key: value` lines below it");
    }
  }

  void assignAt(const YAML::Node& value, const OptionField& field) const {
    try {
      assign(field, value.Scalar());
    } catch (const UsageError& problem) {
      fail(value, problem.what());
    }
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw Error(path_ + ":" + std::to_string(std::max(node.Mark().line, 0) + 1), what);
  }

  const std::string& path_;
  std::vector<OptionField> fields_;
  std::set<std::string> seen_;
};

/// The text of a file, or of the one that comes with the program and has this name.
std::string readText(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  std::error_code failed;
  if (std::filesystem::is_directory(path, failed))
    throw Error(path, "is a folder, expected a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::vector<std::string> names;
    for (const ShippedConfig& shipped : kShippedConfig) {
      if (path == shipped.name) return shipped.yaml;
      names.emplace_back(shipped.name);
    }
    const bool is_name = std::filesystem::path(path).extension().empty();
    throw Error(path, "cannot open" + (is_name ? knownWordsHint(path, names) : std::string()));
  }
  std::string text(kMaxBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.gcount() == static_cast<std::streamsize>(kMaxBytes)) {
    throw Error(path, "expected a file of options, found more than 1 MiB");
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

YAML::Node parse(const std::string& path) {
  try {
    return YAML::Load(readText(path));
  } catch (const YAML::Exception& problem) {
    throw Error(path + ":" + std::to_string(std::max(problem.mark.line, 0) + 1),
                "not YAML: " + problem.msg);
  }
}

/// Text that YAML reads back as this string and nothing else.
std::string quotedForYaml(const std::string& text) {
  const bool plain = !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) &&
                     std::all_of(text.begin(), text.end(), [](unsigned char c) {
                       return std::isalnum(c) || c == '_' || c == '-' || c == '/' || c == '.';
                     });
  const bool reserved = text == "null" || text == "Null" || text == "NULL";
  if (plain && !reserved) return text;
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

std::vector<std::string> partsOf(const std::string& key) {
  std::vector<std::string> parts;
  std::istringstream stream(key);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

/// "group:" lines for the groups of `key` that the line before was not in; returns the indented
/// name.
std::string openGroups(const std::string& key, std::vector<std::string>& open, std::string& yaml) {
  std::vector<std::string> groups = partsOf(key);
  const std::string name = groups.back();
  groups.pop_back();
  const auto different = std::mismatch(groups.begin(), groups.end(), open.begin(), open.end());
  for (auto group = different.first; group != groups.end(); ++group) {
    yaml += std::string(2 * static_cast<std::size_t>(group - groups.begin()), ' ') + *group + ":\n";
  }
  open = groups;
  return std::string(2 * groups.size(), ' ') + name;
}

}  // namespace

std::vector<OptionEntry> listOptions(const Options& options) {
  Options current = options, defaults;
  const std::vector<OptionField> fields = fieldsOf(current), fallbacks = fieldsOf(defaults);
  std::vector<OptionEntry> entries;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string rule = ruleText(fields[i]);
    entries.push_back({fields[i].key, valueText(fields[i]), valueText(fallbacks[i]),
                       fields[i].meaning + (rule.empty() ? "" : "; " + rule)});
  }
  return entries;
}

void setOption(Options& options, const std::string& key, const std::string& value) {
  const std::vector<OptionField> fields = fieldsOf(options);
  const OptionField* field = findField(fields, key);
  if (!field) throw UsageError(unknownKey(key, fields));
  assign(*field, value);
}

void requireValid(const Options& options) {
  Options checked = options;
  requireLegal(fieldsOf(checked));
}

void applyOptionsFile(Options& options, const std::string& path) {
  const YAML::Node root = parse(path);
  if (root.IsNull()) return;  // nothing but comments
  Options changed = options;
  FileReader(changed, path).apply(root, "");
  options = changed;
}

std::string toYaml(const Options& options) {
  Options current = options, defaults;
  const std::vector<OptionField> fields = fieldsOf(current), fallbacks = fieldsOf(defaults);
  std::string yaml;
  std::vector<std::string> open;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string name = openGroups(fields[i].key, open, yaml);
    const std::string value = valueText(fields[i]);
    const bool is_text = std::holds_alternative<std::string*>(fields[i].value);
    yaml += name + ": " + (is_text ? quotedForYaml(value) : value);
    yaml += value == valueText(fallbacks[i]) ? "  # default\n" : "\n";
  }
  return yaml;
}

}  // namespace xview
