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
};

}  // namespace xview::python
