// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/semantic_place.h"

namespace xview {

/// What a point belongs to, by the shape of the points around it; the numbers are the class ids of
/// the label set `shapes`.
enum class Shape : std::uint8_t {
  none,       ///< not finite
  ground,     ///< what lies lowest and runs on without steps
  wall,       ///< flat and upright
  post,       ///< thin and upright
  foliage,    ///< scattered, or too few points to tell
  low_thing,  ///< stands alone, as low and as long as a vehicle
  roof,       ///< flat, high, nothing known below it
  ceiling,    ///< flat, high, over ground
  table,      ///< flat, between knee and head
};
constexpr std::size_t kShapeCount = 9;

/// The classes of the shapes: the label set `shapes`, as config/labels/shapes.yaml has it.
LabelSet labelsOfShapes();

/// Sets the label of every point to its Shape. The points are of one frame whose z points up [m];
/// where they were seen from does not matter. Neighbourhoods follow the spacing of the points.
///
/// The ground is a field of heights: of the lowest points of cells of 1 m those are joined that a
/// slope connects; what is joined and lies above its surroundings by a step is no ground. Above the
/// ground the eigenvalues of the covariance around a point tell planes and lines from the rest. If
/// points are scattered and nobody says how far they err (Point::sigma), what is scattered near by
/// is a wall if it is flat farther around and hardly thicker.
///
/// `size` is the scale of the place (base/semantic_place.h): voxels are those of a town times it,
/// but no finer than in rooms, and only in towns there are vehicles; furniture has their size.
void labelByShape(pcl::PointCloud<Point>& points, double size = kTownScale);

/// Role and kind of unknown classes (ClassInfo::unknown) from the shape of all their points
/// together: what is flat and low is ground, what runs on is a wall, fence or hedge. Of a set whose
/// classes have no names what stands alone is an object, and a vehicle if it has the size of one;
/// of others it stays what it is. z of the cloud is up [m]; points that are not finite do not
/// count, nor do those of a class where most points are of others: labels err. If none of the
/// classes is ground nothing is known of heights, and no class changes; nor does one with too few
/// points to tell. None is unknown afterwards.
LabelSet rolesByShape(const LabelSet& labels, const LabelledCloud& cloud);

}  // namespace xview
