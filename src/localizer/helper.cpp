// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/helper.h"

#include <optional>
#include <utility>

#include "place/shared_frames.h"
#include "process/message.h"
#include "search/scan_helper.h"

namespace xview {

struct Helper::Work {
  std::function<RecordingsOfMap()> open;
  RecordingsOfMap opened;
  std::optional<RecordingsInOneSet> recordings;
  search::ScanHelper scans;

  const RecordingsInOneSet& openedRecordings() {
    if (!recordings) {
      if (open) opened = open();
      std::vector<const FrameSource*> sources;
      for (const auto& source : opened.sources) sources.push_back(source.get());
      recordings.emplace(sources, opened.options);
    }
    return *recordings;
  }
};

Helper::Helper(std::function<RecordingsOfMap()> open) : work_(std::make_unique<Work>()) {
  work_->open = std::move(open);
}
Helper::~Helper() = default;

std::string Helper::answer(const std::string& request) {
  switch (MessageReader(request).next<HelperTask>()) {
    case HelperTask::scan:
      return work_->scans.answer(request);
    case HelperTask::frame:
      return answerFrameRequest(request, work_->openedRecordings());
  }
  MessageReader::fail();
}

}  // namespace xview
