// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "place/lift.h"
#include "place/shapes.h"
#include "xview/base/frame.h"
#include "xview/base/semantic_place.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {

/// Shares of the points by Shape, in [0, 1].
using ShapeShares = std::array<double, kShapeCount>;

/// The recording with classes from the shapes of its points (labelByShape), frame by frame.
/// What it has of labels is left aside. Cameras whose frame is not upright are turned by how they
/// are held, unless options.gravity is aligned. `shapes` is the label set whose ids are those of
/// Shape. `shares`, if given, receives what a few frames consist of.
std::unique_ptr<FrameSource> withShapeLabels(std::unique_ptr<FrameSource> source, LabelSet shapes,
                                             const Options& options, ShapeShares* shares = nullptr);

/// The recording with roles and kinds of its unknown classes: as the classes of the same names have
/// them in a map, if it is given, else by shape (rolesByShape), judged in frames spread over
/// it. Whoever asks for a map of bare ids, or of names that nobody knows, gets streets and walls
/// instead of nothing but objects.
std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const LiftOptions& options, int threads,
                                              const LabelSet* of_map = nullptr);

}  // namespace xview
