// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "xview/options.h"
#include "xview/types/frame.h"

namespace xview {

/// The recording with roles and kinds of its classes from their shapes (rolesByShape), judged in
/// frames spread over it, if its classes have no names; any other recording as it is. Whoever asks
/// for a map of bare ids gets streets and walls instead of nothing but objects.
std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const Options& options);

}  // namespace xview
