// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tool.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace xview::tools {

/// A command with its flags declared, which the texts about it are made of.
struct CommandText {
  Description about;
  const CLI::App* app = nullptr;
};

/// The page of `man xview-COMMAND`.
std::string manPage(const CommandText& command);
/// The page of `man xview`.
std::string manPage(const std::vector<CommandText>& commands);
/// A script for bash that completes commands, flags, what a flag may be set to, and files.
std::string bashCompletion(const std::vector<CommandText>& commands);

}  // namespace xview::tools
