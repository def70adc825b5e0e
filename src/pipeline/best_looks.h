// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/types/labelled_cloud.h"

namespace xview {

/// Which points to keep where things were seen from afar and from near: those that are known about
/// as well as the best ones of their class around them (cells of 1.5 m). Depth errors of stereo
/// grow with the square of the range, and smear a thing along the rays to it. What is good to 0.1 m
/// is kept anywhere.
std::vector<bool> bestLooks(const LabelledCloud& cloud);

}  // namespace xview
