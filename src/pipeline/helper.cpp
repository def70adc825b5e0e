// SPDX-License-Identifier: BSD-3-Clause
#include "xview/helper.h"

#include "pipeline/shared_frames.h"
#include "search/shared_scan.h"
#include "types/message.h"

namespace xview {

struct Helper::Work {
  search::ScanHelper scans;
};

Helper::Helper() : work_(std::make_unique<Work>()) {}
Helper::~Helper() = default;

std::string Helper::answer(const std::string& request) {
  switch (MessageReader(request).next<HelperTask>()) {
    case HelperTask::scan:
      return work_->scans.answer(request);
    case HelperTask::frame:
      return answerFrameRequest(request);
  }
  MessageReader::fail();
}

}  // namespace xview
