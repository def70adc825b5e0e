// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/types/plan_view.h"

namespace xview {

/// A plan view drawn in a frame turned by a few degrees: p_turned = turn * p_plan. Every sample and
/// cell is taken to lie on the ground below it, so what stands h metres above it is drawn
/// h * sin(angle) away from where it is. The view is upright in the turned frame.
PlanView turnedPlan(const PlanView& view, const Eigen::Quaterniond& turn);

}  // namespace xview
