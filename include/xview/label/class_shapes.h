// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"

namespace xview::label {

/// Role and kind of classes that have no names, from the shape of all their points together: what
/// is flat and low is ground, what runs on is a wall, fence or hedge, what stands alone is an
/// object, and a vehicle if it has the size of one. z of the cloud is up [m]; points that are not
/// finite do not count. If none of the classes is ground nothing is known of heights, and `unnamed`
/// is returned as it is; so is every class with too few points to tell.
LabelSet rolesByShape(const LabelSet& unnamed, const LabelledCloud& cloud);

}  // namespace xview::label
