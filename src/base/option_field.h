// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace xview {

/// Closed range of legal values of a numeric option.
struct Range {
  double min, max;
};

/// Legal values of a textual option.
struct Choices {
  std::vector<std::string> values;
};

/// Rule of a textual option that is more than a word: throws UsageError that names the key. An
/// empty text is always legal.
struct Syntax {
  void (*require)(const std::string& key, const std::string& text) = nullptr;
};

// Every options struct has beside it
//
//   template <class Visitor> void visit(FooOptions& options, Visitor&& field) {
//     field("name", options.name, Range{1, 100}, "what it means [unit]");   // int, double
//     field("mode", options.mode, Choices{{"a", "b"}}, "…");                // std::string
//     field("area", options.area, Syntax{requireArea}, "…");                // std::string
//     field("flag", options.flag, "…");                                     // bool, any text
//   }
//
// and nothing else lists the fields: the YAML reader, the command-line flags, --print-config and
// the range checks go through fieldsOf(). A gathering struct calls
// field.group("foo", options.foo), which makes the keys foo.name and foo.mode.

/// One option: its full key, where its value lives, and what values are legal.
struct OptionField {
  std::string key;  ///< "walks.num_walks"
  std::variant<int*, double*, bool*, std::string*> value;
  std::variant<std::monostate, Range, Choices, Syntax> rule;
  std::string meaning;
};

/// The visitor of all visit() functions: writes every field down, with the path of the groups
/// before its name.
class FieldCollector {
 public:
  FieldCollector(std::vector<OptionField>& fields, std::string prefix)
      : fields_(fields), prefix_(std::move(prefix)) {}

  template <class Value, class Rule>
  void operator()(const char* name, Value& value, const Rule& rule, const char* meaning) {
    fields_.push_back({prefix_ + name, &value, rule, meaning});
  }
  template <class Value>
  void operator()(const char* name, Value& value, const char* meaning) {
    fields_.push_back({prefix_ + name, &value, {}, meaning});
  }
  template <class Group>
  void group(const char* name, Group& options) {
    visit(options, FieldCollector(fields_, prefix_ + name + "."));
  }

 private:
  std::vector<OptionField>& fields_;
  std::string prefix_;
};

/// All options of a struct, in the order of its visit function; `prefix` comes before their keys.
/// The pointers live as long as `options`.
template <class Options>
std::vector<OptionField> fieldsOf(Options& options, const std::string& prefix = "") {
  std::vector<OptionField> fields;
  visit(options, FieldCollector(fields, prefix));
  return fields;
}

/// The legal values, "in [2, 8]" or "one of auto, walks, search"; empty if everything is legal.
std::string ruleText(const OptionField& field);
/// The value as text that assign() reads back to the same value.
std::string valueText(const OptionField& field);
/// Sets the value from text. Throws UsageError with key, value and the violated rule.
void assign(const OptionField& field, const std::string& text);
/// Throws UsageError as assign() does if a value could not have been set so.
void requireLegal(const std::vector<OptionField>& fields);

}  // namespace xview
