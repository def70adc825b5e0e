// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace xview::io {

/// A parsed YAML text with the name that its error messages start with.
class YamlFile {
 public:
  static YamlFile read(const std::string& path);                            ///< throws Error
  static YamlFile parse(const std::string& path, const std::string& text);  ///< throws Error

  const YAML::Node& root() const { return root_; }

  /// Throws Error("path:line: what") with the line of the node.
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const;

  /// Checks that the node is a map with no keys but these; an unknown key is an error that names
  /// the nearest known one.
  void requireKeys(const YAML::Node& map, const std::vector<std::string>& known) const;

  std::string text(const YAML::Node& node, const std::string& what) const;
  double number(const YAML::Node& node, const std::string& what) const;  ///< finite
  std::int64_t integer(const YAML::Node& node, const std::string& what, std::int64_t min,
                       std::int64_t max) const;
  bool boolean(const YAML::Node& node, const std::string& what) const;

 private:
  std::string path_;
  YAML::Node root_;
};

}  // namespace xview::io
