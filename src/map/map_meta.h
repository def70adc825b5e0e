// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <map>
#include <string>

#include "damage.h"
#include "xview/map/semantic_map.h"

namespace xview {

/// The table of single values, as text.
using Meta = std::map<std::string, std::string>;

/// `stored_points`: of the cloud, which is thinned on its way into the file.
Meta metaOf(const SemanticMap& map, std::size_t stored_points);

/// These throw Damage if the value is missing or cannot be what is asked for.
const std::string& textIn(const Meta& meta, const std::string& name);
double finiteIn(const Meta& meta, const std::string& name);
void requireCount(const Meta& meta, const std::string& name, std::size_t found);

template <class Number>
Number numberIn(const Meta& meta, const std::string& name) {
  const std::string& text = textIn(meta, name);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw Damage("meta: " + name + " is no number: " + text);
  return value;
}

}  // namespace xview
