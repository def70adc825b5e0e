// SPDX-License-Identifier: BSD-3-Clause
#include "base/option_field.h"

#include <algorithm>
#include <cmath>

#include "base/user_text.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// Assigns text to one type of option; throws UsageError.
struct Assignment {
  const OptionField& field;
  const std::string& text;

  [[noreturn]] void fail(const std::string& rule) const {
    throw UsageError(field.key + " = " + text + ", must be " + rule);
  }
  template <class Number>
  void assignNumber(Number* target, const char* expected) const {
    const auto value = numberFrom<Number>(text);
    if (!value || !std::isfinite(static_cast<double>(*value))) fail(expected);
    const auto* range = std::get_if<Range>(&field.rule);
    if (range && !(*value >= range->min && *value <= range->max)) fail(ruleText(field));
    *target = *value;
  }
  void operator()(int* target) const { assignNumber(target, "a whole number"); }
  void operator()(double* target) const { assignNumber(target, "a number"); }
  void operator()(bool* target) const {
    *target = text == "true" || text == "yes" || text == "on" || text == "1";
    if (!*target && text != "false" && text != "no" && text != "off" && text != "0")
      fail("true or false");
  }
  void operator()(std::string* target) const {
    if (const auto* choices = std::get_if<Choices>(&field.rule)) {
      const auto& known = choices->values;
      if (std::find(known.begin(), known.end(), text) == known.end()) fail(ruleText(field));
    }
    const auto* syntax = std::get_if<Syntax>(&field.rule);
    if (syntax && !text.empty()) syntax->require(field.key, text);
    *target = text;
  }
};

struct AsText {
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const double* value) const { return numberText(*value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return *value; }
};

}  // namespace

std::string ruleText(const OptionField& field) {
  std::string text;
  if (const auto* choices = std::get_if<Choices>(&field.rule)) {
    for (const std::string& word : choices->values)
      text += (text.empty() ? "one of " : ", ") + word;
  } else if (const auto* range = std::get_if<Range>(&field.rule)) {
    text = "in [" + numberText(range->min) + ", " + numberText(range->max) + "]";
  }
  return text;
}

std::string valueText(const OptionField& field) { return std::visit(AsText{}, field.value); }

void assign(const OptionField& field, const std::string& text) {
  std::visit(Assignment{field, text}, field.value);
}

void requireLegal(const std::vector<OptionField>& fields) {
  for (const OptionField& field : fields) assign(field, valueText(field));
}

}  // namespace xview
