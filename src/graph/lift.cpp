// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/lift.h"

#include <limits>

#include "cloud_of_rows.h"
#include "lifting.h"

namespace xview {

double maxRange(const Frame& frame, const LiftOptions& options) {
  if (frame.sensor == Sensor::cloud) return std::numeric_limits<double>::infinity();
  if (frame.sensor == Sensor::lidar) return options.max_range_m * kRangeOfLidar;
  return maxCameraRange(frame, options);
}

LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts) {
  const LiftPlan plan = planOf(frame, options);
  CloudOfRows cloud(plan.origin);
  cloud.reserve(plan.expected);
  const LiftCounts found = liftInto(cloud, plan, frame, set);
  if (counts) *counts = found;
  return cloud.finish();
}

}  // namespace xview
