// SPDX-License-Identifier: BSD-3-Clause
#include "repeatability.h"

#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <unordered_map>

#include "xview/eval/evaluation.h"

namespace xview::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::int64_t cellOf(double p, double side) {
  return static_cast<std::int64_t>(std::floor(p / side));
}

std::uint64_t keyOf(std::int64_t x, std::int64_t y) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
         static_cast<std::uint32_t>(y);
}

/// Landmarks by label and plan-view cell; cells of one label may share a list, so that each
/// candidate is measured.
class LandmarkGrid {
 public:
  LandmarkGrid(const std::vector<Landmark>& landmarks, double reach_m)
      : landmarks_(landmarks), reach_m_(reach_m) {
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const Landmark& l = landmarks[i];
      if (l.position.allFinite()) cells_[l.label][cellKey(l.position, 0, 0)].push_back(i);
    }
  }

  static constexpr std::size_t kNobody = std::numeric_limits<std::size_t>::max();

  /// Distance to the nearest one of the same label, other than number `except`.
  double nearest(const Landmark& l, std::size_t except) const {
    const auto cells = cells_.find(l.label);
    if (cells == cells_.end() || !l.position.allFinite()) return kInfinity;
    double best = kInfinity;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto cell = cells->second.find(cellKey(l.position, dx, dy));
        if (cell == cells->second.end()) continue;
        for (const std::size_t i : cell->second) {
          if (i == except) continue;
          best = std::min(best, (landmarks_[i].position - l.position).norm());
        }
      }
    }
    return best <= reach_m_ ? best : kInfinity;
  }

 private:
  std::uint64_t cellKey(const Eigen::Vector3d& p, int dx, int dy) const {
    return keyOf(cellOf(p.x(), reach_m_) + dx, cellOf(p.y(), reach_m_) + dy);
  }

  using Cells = std::unordered_map<std::uint64_t, std::vector<std::size_t>>;
  const std::vector<Landmark>& landmarks_;
  double reach_m_;
  std::unordered_map<std::uint32_t, Cells> cells_;
};

}  // namespace

std::vector<Landmark> landmarksOf(const SemanticGraph& graph) {
  std::vector<Landmark> result;
  result.reserve(graph.size());
  for (const Vertex& v : graph.vertices) result.push_back({v.label, v.position});
  return result;
}

std::vector<Landmark> landmarksOf(const PlanView& view, double block_m) {
  std::vector<Landmark> result;
  std::set<std::tuple<std::size_t, std::int64_t, std::int64_t>> taken;
  const Eigen::Vector3d origin(view.origin_x, view.origin_y, view.origin_z);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const bool thin = block_m > 0 && !isObject(static_cast<Channel>(c));
    for (const PlanSample& s : view.samples[c]) {
      if (thin && !taken.insert({c, cellOf(s.x, block_m), cellOf(s.y, block_m)}).second) continue;
      result.push_back({static_cast<std::uint32_t>(c), origin + Eigen::Vector3d(s.x, s.y, s.z)});
    }
  }
  return result;
}

std::vector<Landmark> moved(const std::vector<Landmark>& landmarks, const Eigen::Isometry3d& T) {
  std::vector<Landmark> result = landmarks;
  for (Landmark& l : result) l.position = T * l.position;
  return result;
}

std::vector<Landmark> flattened(std::vector<Landmark> landmarks) {
  for (Landmark& l : landmarks) l.position.z() = 0;
  return landmarks;
}

KnownArea::KnownArea(const PlanView& view, double reach_m)
    : cell_m_(view.cell_m), origin_x_(view.origin_x), origin_y_(view.origin_y) {
  const int reach = static_cast<int>(std::floor(reach_m / cell_m_ + 1e-9));
  for (const GroundCell& cell : view.known) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) cells_.insert(keyOf(cell.x + dx, cell.y + dy));
    }
  }
}

bool KnownArea::contains(const Eigen::Vector3d& p) const {
  if (!p.allFinite()) return false;
  return cells_.count(
      keyOf(cellOf(p.x() - origin_x_, cell_m_), cellOf(p.y() - origin_y_, cell_m_)));
}

double Partners::shareWithin(double limit_m) const {
  return xview::shareWithin(distances_m, limit_m, distances_m.size());
}

std::map<std::uint32_t, Partners> findPartners(const std::vector<Landmark>& landmarks,
                                               const std::vector<Landmark>& other,
                                               const KnownArea& known, double reach_m) {
  const LandmarkGrid grid(other, reach_m);
  std::map<std::uint32_t, Partners> result;
  for (const Landmark& l : landmarks) {
    Partners& partners = result[l.label];
    if (known.contains(l.position)) {
      partners.distances_m.push_back(grid.nearest(l, LandmarkGrid::kNobody));
    } else {
      ++partners.unknown;
    }
  }
  return result;
}

std::map<std::uint32_t, std::vector<double>> neighbourDistances(
    const std::vector<Landmark>& landmarks, double reach_m) {
  const LandmarkGrid grid(landmarks, reach_m);
  std::map<std::uint32_t, std::vector<double>> result;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    result[landmarks[i].label].push_back(grid.nearest(landmarks[i], i));
  }
  return result;
}

}  // namespace xview::bench
