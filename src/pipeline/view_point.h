// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/localizer.h"

namespace xview {

/// A cloud or graph whose origin lies outside of what it shows (lifted from a drive, cut from a
/// town) was not seen from there, and on a lever of hundreds of metres a tenth of a degree looks
/// like another place. The same query with its centre as its pose, in which it can be judged,
/// refined and looked for; nothing if its poses were view-points.
std::optional<Query> seenFromItsCentre(const Query& query);

/// The covariance of `T_map_sensor`, if that of a pose with position `p_map` is `covariance`; both
/// are moved by the same left increments (x y z rx ry rz, map frame).
Matrix6d movedCovariance(const Matrix6d& covariance, const Eigen::Vector3d& p_map,
                         const Eigen::Vector3d& to_map);

}  // namespace xview
