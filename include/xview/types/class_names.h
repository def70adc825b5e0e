// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "xview/types/labels.h"

namespace xview {

/// What people call the same thing: a table of lines like "object pole: pole, utility pole"
/// (config/class_names.txt, compiled in).
class ClassNames {
 public:
  /// One line of the table.
  struct Line {
    Role role = Role::object;
    Kind kind = Kind::other_object;
    std::vector<std::string> names;  ///< as words; a leading * stands for any beginning of a word
  };

  /// Throws Error that names `source` and the line.
  static ClassNames parse(std::string_view text, const std::string& source);
  /// The table that comes with the program.
  static const ClassNames& shipped();

  /// The first line that fits; null if there is none.
  const Line* find(const std::string& class_name) const;
  /// The same table with these lines asked first.
  ClassNames extendedBy(const ClassNames& own) const;
  Role role(const std::string& class_name) const;  ///< object if no line fits
  Kind kind(const std::string& class_name) const;  ///< other_object if no line fits

 private:
  std::vector<Line> lines_;
};

/// Letters and digits in lower case without a plural s, so that two spellings of one name are the
/// same: "Traffic_Signs", "traffic-sign" and "TrafficSign" are "trafficsign".
std::string foldedName(const std::string& name);

}  // namespace xview
