// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "graph/cell_index.h"
#include "graph/plan_voxels.h"
#include "xview/graph/plan_view.h"

namespace xview {

/// How the ground is drawn from points that are wrong now and then: labels under trees, stereo
/// noise from the air.
struct GroundRule {
  double quantile;  ///< of the heights in a 2 m cell: low near the ground, the median from the air
  double gate_m;    ///< half thickness of the layer that counts as ground
};
GroundRule groundRule(const PlanOptions& options, bool aerial);

/// Height of the ground on a 2 m lattice, bilinear in between.
class GroundSurface {
 public:
  GroundSurface(const ChunkedVector<PlanVoxel>& voxels, const GroundRule& rule);
  float heightAt(float x, float y) const;
  bool empty() const { return heights_.empty(); }

 private:
  float latticeHeight(std::int32_t x, std::int32_t y, float fallback) const;

  CellIndex index_;
  std::vector<float> heights_;
};

}  // namespace xview
