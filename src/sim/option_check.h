// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>

#include "xview/types/error.h"
#include "xview/types/option_field.h"

namespace xview {

/// A visitor of options that throws UsageError at the first value out of range.
class OptionCheck {
 public:
  explicit OptionCheck(std::string prefix = "") : prefix_(std::move(prefix)) {}

  template <class T>
  void operator()(const char* name, const T& value, const Range& range, const char*) const {
    if (value >= range.min && value <= range.max) return;  // false for NaN
    std::ostringstream text;
    text << prefix_ << name << " = " << value << ", must be in [" << range.min << ", " << range.max
         << "]";
    throw UsageError(text.str());
  }

  void operator()(const char* name, const std::string& value, const Choices& choices,
                  const char*) const {
    const auto& values = choices.values;
    if (std::find(values.begin(), values.end(), value) != values.end()) return;
    std::string text = prefix_ + name + " = " + value + ", must be one of";
    for (const std::string& choice : values) text += " " + choice;
    throw UsageError(text);
  }

  void operator()(const char*, bool, const char*) const {}

  template <class Group>
  void group(const char* name, Group& options) const {
    visit(options, OptionCheck(prefix_ + name + "."));
  }

 private:
  std::string prefix_;
};

}  // namespace xview
