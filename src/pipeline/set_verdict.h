// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "xview/types/localization.h"
#include "xview/verify/verdict.h"

namespace xview {

inline void setVerdict(const Verdict& verdict, Localization& answer) {
  answer.status = verdict.status;
  answer.confidence = verdict.confidence;
  answer.reason = verdict.reason;
}

/// Refuses an accepted answer after all: it is less likely right than not.
inline void takeBack(std::string reason, Localization& answer) {
  answer.status = Status::rejected;
  answer.confidence = std::min(answer.confidence, 0.49);
  answer.reason = std::move(reason);
}

}  // namespace xview
