// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "process/helpers.h"
#include "xview/base/frame.h"
#include "xview/options.h"

namespace xview {

/// Recordings of which a map is made, and its options.
struct RecordingsOfMap {
  std::vector<std::unique_ptr<FrameSource>> sources;
  Options options;
};

/// Works for another process, one of whose Helpers it is.
class Helper {
 public:
  /// `open`: the SharedRecordings of the other process, with what it gives buildMap(); called when
  /// the first of their frames is asked for. Without it frames are refused.
  explicit Helper(std::function<RecordingsOfMap()> open = {});
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
