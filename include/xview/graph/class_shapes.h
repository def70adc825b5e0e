// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "xview/graph/lift.h"
#include "xview/types/frame.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview::graph {

/// Role and kind of classes that have no names, from the shape of their points: what is flat and
/// low is ground, what runs on is a wall, fence or hedge, what stands alone is an object, and a
/// vehicle if it has the size of one. `clouds` are of one frame whose z points up [m]. If none of
/// the classes is ground nothing is known of heights, and `unnamed` is returned as it is; so is
/// every class with too few points to tell.
LabelSet rolesByShape(const LabelSet& unnamed, const std::vector<LabelledCloud>& clouds);

/// The recording with roles and kinds of its classes from their shapes (rolesByShape), judged in
/// frames spread over it, if its classes have no names; any other recording as it is. Whoever asks
/// for a map of bare ids gets streets and walls instead of nothing but objects.
std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const LiftOptions& options, int threads);

}  // namespace xview::graph
