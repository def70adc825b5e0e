// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_set>
#include <vector>

#include "xview/types/graph.h"
#include "xview/types/plan_view.h"

namespace xview::bench {

/// Something that another visit should find again: a vertex, or a sample of a plan view.
struct Landmark {
  std::uint32_t label = 0;  ///< class of a vertex, number of the channel of a sample
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
};

std::vector<Landmark> landmarksOf(const SemanticGraph& graph);
/// Samples in the plan frame (upright). Surfaces are thinned to one sample per block of that side,
/// the first in (y, x) order, since neighbouring cells tell the same; block_m = 0 keeps all.
std::vector<Landmark> landmarksOf(const PlanView& view, double block_m);

/// The landmarks in another frame.
std::vector<Landmark> moved(const std::vector<Landmark>& landmarks, const Eigen::Isometry3d& T);
/// The landmarks as seen from above: z = 0.
std::vector<Landmark> flattened(std::vector<Landmark> landmarks);

/// Where a session saw anything at all, with a rim of reach_m around it. Only what lies there could
/// have been found again.
class KnownArea {
 public:
  KnownArea(const PlanView& view, double reach_m);
  /// `p` in the plan frame (upright) of the view.
  bool contains(const Eigen::Vector3d& p) const;

 private:
  double cell_m_, origin_x_, origin_y_;
  std::unordered_set<std::uint64_t> cells_;
};

/// How near the partners of the landmarks of one label are.
struct Partners {
  std::vector<double> distances_m;  ///< of each landmark in known area; infinite beyond the reach
  std::size_t unknown = 0;          ///< landmarks where the other session saw nothing
  double shareWithin(double limit_m) const;  ///< of those in known area; NaN if there are none
};

/// Per label, the distance of each landmark to the nearest one of the same label in `other`, up to
/// reach_m. Both in the plan frame of `known`, the area of `other`. Several landmarks may share a
/// partner. Positions that are not finite have none.
std::map<std::uint32_t, Partners> findPartners(const std::vector<Landmark>& landmarks,
                                               const std::vector<Landmark>& other,
                                               const KnownArea& known, double reach_m);

/// Per label, the distance of each landmark to the nearest other one of its label in the same set,
/// up to reach_m, in the order of the set: things that were not merged show as short distances.
std::map<std::uint32_t, std::vector<double>> neighbourDistances(
    const std::vector<Landmark>& landmarks, double reach_m);

}  // namespace xview::bench
