// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "xview/base/bev_grid.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"

namespace xview {

constexpr double kBevCell_m = 0.5;   ///< side of a cell of a BEV grid
constexpr double kBevVoxel_m = 0.2;  ///< weights are summed in voxels of this side first
/// Half thickness of the layer that counts as ground; ground classes beyond are obstacles.
constexpr double kGroundGate_m = 0.6;

/// Gathers labelled points of any number of frames and makes one BEV grid of them. The frame of the
/// grid must be gravity-aligned (z up). The cost of adding a frame does not depend on what was
/// added before. The origin of the grid is a whole multiple of 128 cells in each direction, so that
/// views of one frame share their cells. Points that are no numbers or further than 1e8 m from
/// the origin of the frame are left out, and so are classes without information.
class BevGridBuilder {
 public:
  explicit BevGridBuilder(const LabelSet& labels);
  ~BevGridBuilder();

  /// `weights`: of each point; points without a positive one are left out. `near`: per point,
  /// whether it was measured near enough for thin objects; empty = all.
  void add(const LabelledCloud& cloud, const std::vector<float>& weights,
           const std::vector<bool>& near, const Eigen::Isometry3d& T_bev_cloud, bool aerial);

  /// `tells_by_roofs`: what shows roofs and hardly any walls was seen from the air. Rooms have
  /// ceilings, and of cameras it is known.
  BevGrid build(bool tells_by_roofs = false) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Adds what another view of the same frame saw. Where `view` measured the ground, its heights and
/// ground classes stay; upright classes are joined, one sample per cell, since each pass may have
/// seen another side. Objects within 1 m of one of their channel in `view` are the same. Merging a
/// view again changes nothing. `view.aerial` stays. Samples and cells of `view` are in row order,
/// as builders and map files leave them. Views of other cell sizes cannot be merged (UsageError).
void mergeBevGrids(BevGrid& view, const BevGrid& addition);

}  // namespace xview
