// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "xview/options.h"

namespace xview {

/// One option: its full key, where its value lives, and what values are legal.
struct OptionField {
  std::string key;  ///< "walks.num_walks"
  std::variant<int*, double*, bool*, std::string*> value;
  Range range;
  Choices choices;
  Syntax syntax;  ///< of a text that is more than a word
  std::string meaning;
};

/// All options, in the order of the visit functions. The pointers live as long as `options`.
std::vector<OptionField> fieldsOf(Options& options);

/// The value as text that assign() reads back to the same value.
std::string valueText(const OptionField& field);

/// The legal values, "in [2, 8]" or "one of auto, walks, search"; empty if everything is legal.
std::string ruleText(const OptionField& field);

/// Sets the value from text. Throws UsageError with key, value and the violated rule.
void assign(const OptionField& field, const std::string& text);

}  // namespace xview
