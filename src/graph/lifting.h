// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lift_plan.h"
#include "point_row.h"
#include "xview/graph/lift.h"

namespace xview {

/// Takes lifted points, row by row.
class PointSink {
 public:
  virtual ~PointSink() = default;
  virtual void add(const PointRow& row) = 0;
};

/// Hands the points of a frame that count to `sink`, and counts the others.
LiftCounts liftInto(PointSink& sink, const LiftPlan& plan, const Frame& frame, const LabelSet& set);

}  // namespace xview
