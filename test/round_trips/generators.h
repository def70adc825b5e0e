// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <string>

#include "xview/map/semantic_map.h"

// Small random values of the types that files hold; they shrink to simpler ones where a property
// fails.

namespace xview::test {

/// A path in one folder of this process, in memory where there is such a file system: files are
/// written hundreds of times.
std::string scratch(const std::string& name);

/// Finite, of either sign, at most `largest`, with all digits of a double.
rc::Gen<double> anyNumber(double largest);
/// Not negative.
rc::Gen<double> anyLength(double largest);
/// Words with one blank between two: what the comments of PLY and PCD can hold.
rc::Gen<std::string> anyName();
/// Any UTF-8 without zeros: quotes, control characters, line ends.
rc::Gen<std::string> anyText();
/// Within a kilometre.
rc::Gen<Eigen::Isometry3d> anyPose();
/// At least one class, whose roles are told; ids up to `largest_id`.
rc::Gen<LabelSet> anyLabels(std::uint32_t largest_id = 0xFFFFFFFF);
rc::Gen<SemanticGraph> anyGraph();
/// Points within 100 m of each other, without views; `far`: around an origin of its own.
rc::Gen<LabelledCloud> anyCloud(bool far);
/// A map with something of everything.
rc::Gen<map::SemanticMap> anyMap();

}  // namespace xview::test
