// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "answer.h"

namespace xview::python {

/// An answer as the program prints it, and what was noted on the way.
struct Fix {
  std::shared_ptr<const tools::Answer> answer;
  std::vector<std::string> notes;
  std::string json = {};  ///< of a Fix that was read: the line it was read from
  std::string toJson() const { return json.empty() ? tools::toJson(*answer) : json; }
};

}  // namespace xview::python
