// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>

namespace xview::test {

/// True if $XVIEW_NIGHTLY is set, as by `.ci/run --nightly`: a test then tries all cases of which
/// it tries some otherwise.
inline bool isNightly() { return std::getenv("XVIEW_NIGHTLY") != nullptr; }

}  // namespace xview::test
