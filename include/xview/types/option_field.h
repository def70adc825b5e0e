// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
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
// the range checks go through fieldsOf() (option_fields.h). A gathering struct calls
// field.group("foo", options.foo), which makes the keys foo.name and foo.mode.

}  // namespace xview
