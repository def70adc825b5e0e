// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/localization.h"
#include "xview/verify/verdict.h"

namespace xview {

inline void setVerdict(const Verdict& verdict, Localization& answer) {
  answer.status = verdict.status;
  answer.confidence = verdict.confidence;
  answer.reason = verdict.reason;
}

}  // namespace xview
