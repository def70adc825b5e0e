// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "xview/options.h"

namespace xview {

/// One option as the command line and --print-config see it.
struct OptionEntry {
  std::string key;       ///< "walks.num_walks"
  std::string value;     ///< current value as text
  std::string fallback;  ///< default as text
  std::string help;      ///< meaning, unit and range
};

std::vector<OptionEntry> listOptions(const Options& options);

/// Sets one option from text. Throws UsageError: unknown key (names the nearest known one), not a
/// number, out of range
/// ("walks.walk_length = 0, must be in [2, 8]"), not among the choices.
void setOption(Options& options, const std::string& key, const std::string& value);

/// Applies a YAML file (nested maps; only what differs from the defaults), or the one of this name
/// that comes with the program ("rgbd"). Throws Error with path:line for anything unknown or wrong.
void applyOptionsFile(Options& options, const std::string& path);

/// All options as YAML that applyOptionsFile reads back to the same values; defaults carry the
/// comment "# default".
std::string toYaml(const Options& options);

}  // namespace xview
