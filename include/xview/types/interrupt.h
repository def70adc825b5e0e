// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace xview {

/// What an interrupt calls before it ends the program (removeUnfinishedOnInterrupt), on a thread of
/// its own: a server answers what is under way.
void finishOnInterrupt(std::function<void()> finish);

}  // namespace xview
