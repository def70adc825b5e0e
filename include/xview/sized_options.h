// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/options.h"

namespace xview {

/// The options as a place of this size has them, in its own metres: lengths that nobody set are
/// those of a town times the size.
Options atSize(Options options, double size);

/// The same options for a place that was brought to lengths of a town: what nobody set is as it
/// is, and what somebody set in metres of the place becomes longer by as much as the place does.
Options inTownLengths(Options options, double size);

}  // namespace xview
