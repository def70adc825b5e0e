// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs.h"
#include "listening.h"
#include "tool.h"

namespace xview::tools {

/// What a server was asked for.
struct Serving {
  InputFlags input;
  Listening where;
  int max_body_mb = 256, jobs = 2;
};

}  // namespace xview::tools

/// The function of the module xview_serve: answers requests until the process ends. Throws Error.
extern "C" void xviewServe(const xview::tools::Serving& serving, const xview::tools::Job& job);
