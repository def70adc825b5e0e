// SPDX-License-Identifier: BSD-3-Clause
#include "option_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "xview/types/error.h"

namespace xview {
namespace {

/// The visitor of all visit() functions: writes every field down, with the path of the groups
/// before its name.
class FieldCollector {
 public:
  explicit FieldCollector(std::vector<OptionField>& fields, std::string prefix = "")
      : fields_(fields), prefix_(std::move(prefix)) {}

  template <class Value>
  void operator()(const char* name, Value& value, const Range& range, const char* meaning) {
    fields_.push_back({prefix_ + name, &value, range, {}, {}, meaning});
  }
  void operator()(const char* name, std::string& value, const Choices& choices,
                  const char* meaning) {
    fields_.push_back({prefix_ + name, &value, {}, choices, {}, meaning});
  }
  void operator()(const char* name, std::string& value, const Syntax& syntax, const char* meaning) {
    fields_.push_back({prefix_ + name, &value, {}, {}, syntax, meaning});
  }
  template <class Value>
  void operator()(const char* name, Value& value, const char* meaning) {
    fields_.push_back({prefix_ + name, &value, {}, {}, {}, meaning});
  }
  template <class Group>
  void group(const char* name, Group& options) {
    visit(options, FieldCollector(fields_, prefix_ + name + "."));
  }

 private:
  std::vector<OptionField>& fields_;
  std::string prefix_;
};

template <class Number>
std::string numberText(Number value) {
  char text[40];
  const auto result = std::to_chars(text, text + sizeof text, value);
  return std::string(text, result.ptr);
}

template <class Number>
bool parseNumber(const std::string& text, Number& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc() && stop == end && std::isfinite(static_cast<double>(value));
}

bool parseBool(const std::string& text, bool& value) {
  value = text == "true" || text == "yes" || text == "on" || text == "1";
  return value || text == "false" || text == "no" || text == "off" || text == "0";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Assigns text to one type of option; throws UsageError.
struct Assignment {
  const OptionField& field;
  const std::string& text;

  [[noreturn]] void fail(const std::string& rule) const {
    throw UsageError(field.key + " = " + text + ", " + rule);
  }
  template <class Number>
  void assignNumber(Number* target, const char* rule) const {
    Number value{};
    if (!parseNumber(text, value)) fail(rule);
    if (!(value >= field.range.min && value <= field.range.max)) fail("must be " + ruleText(field));
    *target = value;
  }
  void operator()(int* target) const { assignNumber(target, "must be a whole number"); }
  void operator()(double* target) const { assignNumber(target, "must be a number"); }
  void operator()(bool* target) const {
    bool value = false;
    if (!parseBool(text, value)) fail("must be true or false");
    *target = value;
  }
  void operator()(std::string* target) const {
    const auto& known = field.choices.values;
    if (!known.empty() && std::find(known.begin(), known.end(), text) == known.end()) {
      fail("must be " + ruleText(field));
    }
    if (field.syntax.require && !text.empty()) field.syntax.require(field.key, text);
    *target = text;
  }
};

struct AsText {
  std::string operator()(const int* value) const { return numberText(*value); }
  std::string operator()(const double* value) const { return numberText(*value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return *value; }
};

}  // namespace

std::vector<OptionField> fieldsOf(Options& options) {
  std::vector<OptionField> fields;
  visit(options, FieldCollector(fields));
  return fields;
}

std::string valueText(const OptionField& field) { return std::visit(AsText{}, field.value); }

std::string ruleText(const OptionField& field) {
  if (!field.choices.values.empty()) return "one of " + joined(field.choices.values);
  const bool low = std::isfinite(field.range.min), high = std::isfinite(field.range.max);
  if (low && high) {
    return "in [" + numberText(field.range.min) + ", " + numberText(field.range.max) + "]";
  }
  if (low) return ">= " + numberText(field.range.min);
  return high ? "<= " + numberText(field.range.max) : "";
}

void assign(const OptionField& field, const std::string& text) {
  std::visit(Assignment{field, text}, field.value);
}

}  // namespace xview
