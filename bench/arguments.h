// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "xview/options.h"

namespace xview::bench {

using Flags = std::map<std::string, std::function<void(const std::string& value)>>;

/// The operands. Every word with "--" takes the next one as its value: those in `flags` go there,
/// all others are options. Throws UsageError with `usage` if there are fewer than `least` operands.
std::vector<std::string> parseArguments(int argc, char** argv, const Flags& flags, Options& options,
                                        std::size_t least, const std::string& usage);

/// What stands between commas.
std::vector<std::string> words(const std::string& text);

/// A flag that is a number.
std::function<void(const std::string&)> into(double& number);

}  // namespace xview::bench
