// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "xview/types/helpers.h"

namespace xview {

/// Works for another process, one of whose Helpers it is.
class Helper {
 public:
  Helper();
  ~Helper();
  Helper(const Helper&) = delete;
  Helper& operator=(const Helper&) = delete;

  /// Of a request that the other process has sent. Throws Error for anything else, and what the
  /// work throws.
  std::string answer(const std::string& request);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace xview
