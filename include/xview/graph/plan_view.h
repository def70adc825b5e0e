// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/option_field.h"
#include "xview/types/plan_view.h"

namespace xview {

struct PlanOptions {
  double cell_m = 0.5;         ///< side of a cell
  double voxel_m = 0.2;        ///< votes are gathered in voxels of this side first
  double min_votes = 1;        ///< a cell says something about a class from so many votes on
  double min_share = 0.5;      ///< and if the class holds this share of the cell
  double min_height_m = 0.25;  ///< upright classes below this are labels spilt on the ground
  double ground_gate_m = 0.6;  ///< ground classes further than this above the surface are obstacles
  double peak_votes = 2;       ///< a pole, sign or light is a density peak of so many votes
  double min_aerial_share = 0.5;  ///< a view is aerial if this share of its votes came from the air
};

template <class Visitor>
void visit(PlanOptions& o, Visitor&& field) {
  field("cell_m", o.cell_m, Range{0.1, 5}, "side of a plan-view cell [m]");
  field("voxel_m", o.voxel_m, Range{0.02, 1}, "side of the voxels in which votes are gathered [m]");
  field("min_votes", o.min_votes, Range{0, 1e6}, "votes that a cell needs to speak for a class");
  field("min_share", o.min_share, Range{0, 1}, "share of a cell's votes that a class needs");
  field("min_height_m", o.min_height_m, Range{0, 10},
        "ignore upright classes nearer to the ground than this [m]");
  field("ground_gate_m", o.ground_gate_m, Range{0.05, 10},
        "ground classes further than this above the ground surface are obstacles [m]");
  field("peak_votes", o.peak_votes, Range{0, 1e6},
        "votes of a density peak that make a pole, sign or light");
  field("min_aerial_share", o.min_aerial_share, Range{0, 1},
        "share of aerial votes that makes a view aerial");
}

/// Gathers labelled points of any number of frames and draws the plan view of all of them. The plan
/// frame must be gravity-aligned (z up). The cost of adding a frame does not depend on what was
/// added before. The origin of the view is a whole multiple of 128 cells in each direction, so that
/// views of one frame share their cells. Points that are no numbers or further than 1e8 m from
/// the origin of the frame are left out, and so are classes without information.
class PlanViewBuilder {
 public:
  PlanViewBuilder(const LabelSet& labels, const PlanOptions& options);
  ~PlanViewBuilder();
  PlanViewBuilder(PlanViewBuilder&&) noexcept;
  PlanViewBuilder& operator=(PlanViewBuilder&&) noexcept;

  /// `votes`: weight of each point; those without a positive one are left out. `near`: per point,
  /// whether it was measured near enough for thin objects; empty = all.
  void add(const LabelledCloud& cloud, const std::vector<float>& votes,
           const std::vector<bool>& near, const Eigen::Isometry3d& T_plan_cloud, bool aerial);

  PlanView build() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace xview
