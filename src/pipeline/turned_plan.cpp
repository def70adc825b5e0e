// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/turned_plan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace xview {
namespace {

/// Of one view: from its own coordinates to those of the turned one, which has the same origin.
class Turn {
 public:
  Turn(const PlanView& view, const Eigen::Quaterniond& turn)
      : origin_(view.origin_x, view.origin_y, view.origin_z), turn_(turn) {}

  Eigen::Vector3d operator()(double x, double y, double z) const {
    return turn_ * (origin_ + Eigen::Vector3d(x, y, z)) - origin_;
  }

 private:
  Eigen::Vector3d origin_;
  Eigen::Quaterniond turn_;
};

/// Sorted, one per cell: a measured one if there is one, else the first.
std::vector<GroundCell> onePerCell(std::vector<GroundCell> cells) {
  std::stable_sort(cells.begin(), cells.end(), [](const GroundCell& a, const GroundCell& b) {
    return std::tuple(a.y, a.x, !a.measured) < std::tuple(b.y, b.x, !b.measured);
  });
  cells.erase(std::unique(cells.begin(), cells.end(),
                          [](const GroundCell& a, const GroundCell& b) {
                            return a.x == b.x && a.y == b.y;
                          }),
              cells.end());
  return cells;
}

}  // namespace

PlanView turnedPlan(const PlanView& view, const Eigen::Quaterniond& turn) {
  PlanView turned = view;
  turned.upright = Eigen::Quaterniond::Identity();
  const Turn to_turned(view, turn);
  for (auto& channel : turned.samples) {
    for (PlanSample& s : channel) {
      const Eigen::Vector3f p = to_turned(s.x, s.y, s.z).cast<float>();
      s = {p.x(), p.y(), p.z()};
    }
  }
  for (GroundCell& cell : turned.known) {
    const Eigen::Vector3d p =
        to_turned((cell.x + 0.5) * view.cell_m, (cell.y + 0.5) * view.cell_m, cell.z);
    cell.x = static_cast<std::int32_t>(std::floor(p.x() / view.cell_m));
    cell.y = static_cast<std::int32_t>(std::floor(p.y() / view.cell_m));
    cell.z = static_cast<float>(p.z());
  }
  turned.known = onePerCell(std::move(turned.known));
  return turned;
}

}  // namespace xview
