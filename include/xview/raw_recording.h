// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "xview/graph/lift.h"
#include "xview/label/shapes.h"
#include "xview/options.h"
#include "xview/types/frame.h"
#include "xview/types/semantic_place.h"

namespace xview {

/// The name of the label set of classes from shapes.
constexpr const char* kShapes = "shapes";
inline bool knowsShapesOnly(const LabelSet& labels) { return labels.name() == kShapes; }

/// Shares of the points by Shape, in [0, 1].
using ShapeShares = std::array<double, label::kShapes>;

/// The recording with classes from the shapes of its points (label::labelByShape), frame by frame.
/// What it has of labels is left aside. Cameras whose frame is not upright are turned by how they
/// are held, unless options.gravity is aligned. `shapes` is the label set whose ids are those of
/// label::Shape. `shares`, if given, receives what a few frames consist of.
std::unique_ptr<FrameSource> withShapeLabels(std::unique_ptr<FrameSource> source, LabelSet shapes,
                                             const Options& options, ShapeShares* shares = nullptr);

/// The recording with roles and kinds of its unknown classes: as the classes of the same names have
/// them in a map, if it is given, else by shape (label::rolesByShape), judged in frames spread over
/// it. Whoever asks for a map of bare ids, or of names that nobody knows, gets streets and walls
/// instead of nothing but objects.
std::unique_ptr<FrameSource> withRolesByShape(std::unique_ptr<FrameSource> source,
                                              const graph::LiftOptions& lift, int threads,
                                              const LabelSet* of_map = nullptr);

/// A recording with the classes that maps and queries are made of: its own, with
/// withRolesByShape(); those of shapes if it has none, or if the map knows nothing else. The
/// recording must outlive the result.
std::unique_ptr<const FrameSource> withClasses(const FrameSource& recording, const Options& options,
                                               const LabelSet* of_map = nullptr);

/// A place with the classes of `shapes` instead of its own, by their kinds: what a raw query can
/// be compared with.
void reduceToShapes(const LabelSet& shapes, Place& place);

}  // namespace xview
