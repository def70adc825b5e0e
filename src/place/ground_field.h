// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "base/cells.h"
#include "xview/base/labelled_cloud.h"

namespace xview {

/// Height of the ground under points whose z points up, from the points alone.
class GroundField {
 public:
  static constexpr float kCell_m = 1;

  /// Points that are not finite have no cell, and do not count.
  explicit GroundField(const pcl::PointCloud<Point>& points);

  float heightAt(float x, float y) const { return ground_.heightAt(x, y); }  ///< bilinear [m]
  /// Whether the lowest that was seen above this place is ground.
  bool isSeenAt(float x, float y) const;

 private:
  void findLowest(const pcl::PointCloud<Point>& points);
  void joinCells();
  void chooseGround();
  float toleranceOf(std::size_t cell, std::size_t other, float distance_m) const;

  HeightLattice ground_{kCell_m, {}, {}};
  std::vector<float> lowest_;                ///< of each cell [m]
  std::vector<float> sigma_;                 ///< error of that [m]
  std::vector<std::uint32_t> component_of_;  ///< of each cell: what slopes join
  std::vector<std::uint8_t> is_ground_;
};

}  // namespace xview
