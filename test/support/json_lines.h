// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace xview::test {

using Json = nlohmann::ordered_json;

/// One object per line, as `localize --json` prints them.
std::vector<Json> jsonLines(const std::string& text);

/// The same lines without what the clock decides.
std::string withoutTimes(const std::string& text);

}  // namespace xview::test
