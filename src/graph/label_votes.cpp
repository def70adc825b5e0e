// SPDX-License-Identifier: BSD-3-Clause
#include "label_votes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

namespace xview {
namespace {

constexpr double kLeastExtent_m = 0.3;  ///< boxes of thin things and of single views are no volume
constexpr double kLeastOverlap = 0.5;   ///< of the smaller box
constexpr std::size_t kSeldom = 4;      ///< together in one of so many frames, at most
constexpr std::size_t kLeastSeen = 3;   ///< frames of what may stand for others

using Cell = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

Cell cellOf(const Eigen::Vector3d& p, double side) {
  const auto index = [side](double c) {
    return static_cast<std::int64_t>(std::floor(std::clamp(c / side, -9e15, 9e15)));
  };
  return {index(p.x()), index(p.y()), index(p.z())};
}

bool boxesOverlap(const Observed& a, const Observed& b) {
  const Eigen::Array3d size_a = a.extent.array().max(kLeastExtent_m);
  const Eigen::Array3d size_b = b.extent.array().max(kLeastExtent_m);
  const Eigen::Array3d shift = (a.position - b.position).array().abs();
  const Eigen::Array3d common = ((size_a + size_b) / 2 - shift).min(size_a.min(size_b)).max(0.0);
  return common.prod() >= kLeastOverlap * std::min(size_a.prod(), size_b.prod());
}

bool seldomTogether(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::size_t together = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) ++together;
    const bool advance_a = *i <= *j, advance_b = *j <= *i;
    i += advance_a;
    j += advance_b;
  }
  return together * kSeldom <= std::min(a.size(), b.size());
}

bool mayBeSame(const Observed& a, const Observed& b, double reach_m) {
  return a.label != b.label && a.role == b.role && (a.position - b.position).norm() <= reach_m &&
         boxesOverlap(a, b) && seldomTogether(a.frames, b.frames);
}

/// Most frames first.
std::vector<std::size_t> byObservations(const std::vector<Observed>& all) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return all[a].frames.size() > all[b].frames.size();
  });
  return order;
}

}  // namespace

std::vector<std::size_t> sameThings(const std::vector<Observed>& all, double reach_m) {
  std::vector<std::size_t> same(all.size());
  std::iota(same.begin(), same.end(), std::size_t{0});
  if (reach_m <= 0) return same;
  std::map<Cell, std::vector<std::size_t>> leaders;
  for (const std::size_t i : byObservations(all)) {
    const auto [x, y, z] = cellOf(all[i].position, reach_m);
    double nearest = std::numeric_limits<double>::infinity();
    for (int n = 0; n < 27; ++n) {
      const auto found = leaders.find({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
      if (found == leaders.end()) continue;
      for (const std::size_t leader : found->second) {
        const double distance = (all[i].position - all[leader].position).norm();
        if (distance >= nearest || !mayBeSame(all[i], all[leader], reach_m)) continue;
        nearest = distance;
        same[i] = leader;
      }
    }
    if (same[i] == i && all[i].frames.size() >= kLeastSeen) leaders[{x, y, z}].push_back(i);
  }
  return same;
}

}  // namespace xview
