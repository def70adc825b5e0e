// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/cells.h"
#include "localizer/query_check.h"
#include "map/contents.h"
#include "place/sound_input.h"
#include "xview/mapper.h"

namespace xview {
namespace {

/// Cells under the quarters of moved cells. So no cell between moved ones is left out, and cells of
/// which one quarter only is covered are not known.
std::vector<GroundCell> movedCells(const BevGrid& view, const Eigen::Isometry3d& T,
                                   const Eigen::Vector3d& origin) {
  const Eigen::Vector3d old_origin(view.origin_x, view.origin_y, view.origin_z);
  std::vector<GroundCell> quarters;
  quarters.reserve(4 * view.known.size());
  for (const GroundCell& cell : view.known) {
    for (const double y : {0.25, 0.75}) {
      for (const double x : {0.25, 0.75}) {
        const Eigen::Vector3d p =
            T * (old_origin +
                 Eigen::Vector3d((cell.x + x) * view.cell_m, (cell.y + y) * view.cell_m, cell.z)) -
            origin;
        quarters.push_back({floorToInt(p.x() / view.cell_m), floorToInt(p.y() / view.cell_m),
                            static_cast<float>(p.z()), cell.measured});
      }
    }
  }
  std::stable_sort(quarters.begin(), quarters.end(), InRowOrder());
  std::vector<GroundCell> cells;
  for (auto first = quarters.begin(); first != quarters.end();) {
    const auto last = std::find_if(first, quarters.end(), [&](const GroundCell& other) {
      return other.x != first->x || other.y != first->y;
    });
    const auto measured =
        std::count_if(first, last, [](const GroundCell& c) { return c.measured; });
    if (last - first > 1) {
      cells.push_back(*(first + (last - first) / 2));
      cells.back().measured = 2 * measured >= last - first;
    }
    first = last;
  }
  return cells;
}

BevGrid movedBev(const BevGrid& view, const Eigen::Isometry3d& T_new_old,
                 const Eigen::Quaterniond& upright) {
  BevGrid moved = view;
  moved.alignment = upright;
  if (view.known.empty()) return moved;
  const Eigen::Isometry3d T = upright * T_new_old * view.alignment.conjugate();
  const Eigen::Vector3d old_origin(view.origin_x, view.origin_y, view.origin_z);
  Eigen::Vector3d origin = T * old_origin;
  for (const int axis : {0, 1}) origin[axis] = std::floor(origin[axis] / view.cell_m) * view.cell_m;
  moved.origin_x = origin.x();
  moved.origin_y = origin.y();
  moved.origin_z = origin.z();
  for (auto& channel : moved.samples) {
    for (BevSample& s : channel) {
      const Eigen::Vector3d p = T * (old_origin + Eigen::Vector3d(s.x, s.y, s.z)) - origin;
      s = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    }
    std::sort(channel.begin(), channel.end(), InRowOrder());
  }
  moved.known = movedCells(view, T, origin);
  return moved;
}

}  // namespace

map::SemanticMap inFrameOf(const map::SemanticMap& map, map::SemanticMap other,
                           const Eigen::Isometry3d& T_map_other) {
  requireNear("T_map_other", T_map_other, map.size);
  map::unpackPoints(other);
  for (Vertex& v : other.graph.vertices) v.position = T_map_other * v.position;
  const Eigen::Matrix3f R = T_map_other.linear().cast<float>();
  for (Point& p : other.cloud.points) p.getVector3fMap() = R * p.getVector3fMap();
  other.cloud.origin = T_map_other * other.cloud.origin;
  for (Eigen::Isometry3d& T : other.poses) T = T_map_other * T;
  other.bev = movedBev(other.bev, T_map_other, map.bev.alignment);
  return other;
}

}  // namespace xview
