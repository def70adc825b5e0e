// SPDX-License-Identifier: BSD-3-Clause
#include "yaml_file.h"

#include <algorithm>
#include <cmath>

#include "base/user_text.h"
#include "input_file.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

constexpr std::uint64_t kMaxBytes = 4 << 20;

}  // namespace

YamlFile YamlFile::read(const std::string& path) {
  InputFile file(path);
  if (file.size() > kMaxBytes) file.fail("expected a small YAML file, found more than 4 MiB");
  std::string text(file.size(), '\0');
  file.readBytes(text.data(), text.size());
  return parse(path, text);
}

YamlFile YamlFile::parse(const std::string& path, const std::string& text) {
  YamlFile file;
  file.path_ = path;
  try {
    file.root_ = YAML::Load(text);
  } catch (const YAML::Exception& problem) {
    throw Error(fmt::format("{}:{}", path, std::max(problem.mark.line, 0) + 1),
                "not YAML: " + problem.msg);
  }
  return file;
}

void YamlFile::fail(const YAML::Node& node, const std::string& what) const {
  throw Error(path_ + ":" + std::to_string(std::max(node.Mark().line, 0) + 1), what);
}

void YamlFile::requireKeys(const YAML::Node& map, const std::vector<std::string>& known) const {
  if (!map.IsMap()) fail(map, "expected `key: value` lines");
  std::vector<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = text(entry.first, "a key");
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      fail(entry.first, "unknown key " + inQuotes(key) + knownWordsHint(key, known));
    }
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
      fail(entry.first, "key " + inQuotes(key) + " a second time");
    }
    seen.push_back(key);
  }
}

std::string YamlFile::text(const YAML::Node& node, const std::string& what) const {
  if (!node.IsScalar()) fail(node, what + ": expected one value, found none or several");
  return node.Scalar();
}

double YamlFile::number(const YAML::Node& node, const std::string& what) const {
  const std::string word = text(node, what);
  const std::optional<double> value = numberFrom<double>(word);
  if (!value || !std::isfinite(*value)) {
    fail(node, what + ": expected a number, found " + inQuotes(word));
  }
  return *value;
}

std::int64_t YamlFile::integer(const YAML::Node& node, const std::string& what, std::int64_t min,
                               std::int64_t max) const {
  const std::string word = text(node, what);
  const std::optional<std::int64_t> value = numberFrom<std::int64_t>(word);
  if (!value || *value < min || *value > max) {
    fail(node, fmt::format("{}: expected a whole number in [{}, {}], found {}", what, min, max,
                           inQuotes(word)));
  }
  return *value;
}

bool YamlFile::boolean(const YAML::Node& node, const std::string& what) const {
  const std::string word = text(node, what);
  bool value = false;
  if (!YAML::convert<bool>::decode(node, value)) {
    fail(node, what + ": expected true or false, found " + inQuotes(word));
  }
  return value;
}

}  // namespace xview::io
