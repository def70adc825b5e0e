// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/other_heights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/cells.h"
#include "base/stored_cloud.h"
#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "place/storeys.h"

namespace xview {
namespace {

constexpr double kVoxel_m = 0.4;        ///< side, in canonical lengths: 10 cm in a room
constexpr double kReach_m = 100;        ///< from the middle of a query to what is looked at
constexpr std::size_t kAsked = 3000;    ///< voxels of a query that are looked up, at most
constexpr double kLiesOnMap = 0.25;     ///< share of voxels from which on heights are compared
constexpr std::size_t kFewVoxels = 40;  ///< of a kind, that say nothing about it

/// Occupied voxels, column by column.
class Voxels {
 public:
  void add(const Eigen::Vector3d& p) {
    const std::int32_t column =
        columns_.findOrAdd(floorToInt(p.x() / kVoxel_m), floorToInt(p.y() / kVoxel_m));
    if (static_cast<std::size_t>(column) == heights_.size()) heights_.emplace_back();
    std::vector<std::int32_t>& heights = heights_[column];
    const std::int32_t z = floorToInt(p.z() / kVoxel_m);
    const auto at = std::lower_bound(heights.begin(), heights.end(), z);
    if (at == heights.end() || *at != z) heights.insert(at, z);
  }

  bool any(std::int32_t x, std::int32_t y, std::int32_t low, std::int32_t high) const {
    const std::int32_t column = columns_.find(x, y);
    if (column < 0) return false;
    const std::vector<std::int32_t>& heights = heights_[column];
    const auto at = std::lower_bound(heights.begin(), heights.end(), low);
    return at != heights.end() && *at <= high;
  }

  /// Whether it is a piece of a level surface: it goes on at three of its four sides, and nothing
  /// stands on it or hangs below.
  bool isLevel(std::int32_t x, std::int32_t y, std::int32_t z) const {
    constexpr std::int32_t kClear = 3;
    if (any(x, y, z - kClear, z - 1) || any(x, y, z + 1, z + kClear)) return false;
    return any(x - 1, y, z - 1, z + 1) + any(x + 1, y, z - 1, z + 1) + any(x, y - 1, z - 1, z + 1) +
               any(x, y + 1, z - 1, z + 1) >=
           3;
  }

  template <class Visit>
  void forAll(const Visit& visit) const {
    for (std::size_t i = 0; i < heights_.size(); ++i) {
      for (const std::int32_t z : heights_[i])
        visit(columns_.cells()[i].x, columns_.cells()[i].y, z);
    }
  }

 private:
  CellIndex columns_;
  std::vector<std::vector<std::int32_t>> heights_;  ///< sorted
};

struct AskedVoxel {
  std::int32_t x, y, z;
};

/// Share of them that lies on the map when all are raised.
double shareOn(const Voxels& map, const std::vector<AskedVoxel>& asked, std::int32_t raised,
               bool level) {
  const auto isOn = [&](const AskedVoxel& v) {
    const std::int32_t z = v.z + raised;
    if (!level) return map.any(v.x, v.y, z, z);
    return (map.any(v.x, v.y, z, z) && map.isLevel(v.x, v.y, z)) ||
           (map.any(v.x, v.y, z - 1, z - 1) && map.isLevel(v.x, v.y, z - 1)) ||
           (map.any(v.x, v.y, z + 1, z + 1) && map.isLevel(v.x, v.y, z + 1));
  };
  return static_cast<double>(std::count_if(asked.begin(), asked.end(), isOn)) /
         static_cast<double>(asked.size());
}

void keepSome(std::vector<AskedVoxel>& asked) {
  const std::size_t step = 1 + asked.size() / kAsked;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < asked.size(); i += step) asked[kept++] = asked[i];
  asked.resize(kept);
}

}  // namespace

OtherHeight bestOtherHeight(const Query& query, const map::SemanticMap& map,
                            const Eigen::Isometry3d& T_map_query) {
  Voxels of_query, of_map;
  Eigen::AlignedBox3d box;
  const Eigen::Vector3d middle = T_map_query * middleOf(query);
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const Eigen::Vector3d p = T_map_query * query.cloud.position(i);
    if ((p - middle).norm() > kReach_m) continue;
    box.extend(p);
    of_query.add(p);
  }
  if (box.isEmpty()) return {};

  const Eigen::Vector3d& origin = map.cloud.origin;
  const Eigen::AlignedBox2d below(box.min().head<2>(), box.max().head<2>());
  const auto isNear = [&](const PlaneCell& column) {
    return below.intersects(StoredCloud::squareOf(column, origin));
  };
  double lowest = box.min().z(), highest = box.max().z();
  map::forPoints(map, isNear, [&](const LabelledCloud& points) {
    for (const Point& point : points.points) {
      const Eigen::Vector3d p = origin + point.getVector3fMap().cast<double>();
      if (!below.contains(p.head<2>()) || std::abs(p.z() - middle.z()) > kReach_m) continue;
      lowest = std::min(lowest, p.z());
      highest = std::max(highest, p.z());
      of_map.add(p);
    }
  });

  std::vector<AskedVoxel> level, other;
  of_query.forAll([&](std::int32_t x, std::int32_t y, std::int32_t z) {
    (of_query.isLevel(x, y, z) ? level : other).push_back({x, y, z});
  });
  if (level.size() < kFewVoxels || other.size() < kFewVoxels) return {};
  keepSome(level);
  keepSome(other);
  const double level_here = shareOn(of_map, level, 0, true),
               other_here = shareOn(of_map, other, 0, false);
  if (std::min(level_here, other_here) < kLiesOnMap) return {};

  const auto steps = [](double length) { return floorToInt(length / kVoxel_m); };
  const std::int32_t storey = 1 + steps(kLowestStorey_m / map.size);
  OtherHeight best;
  for (std::int32_t raised = steps(lowest - box.max().z());
       raised <= steps(highest - box.min().z()); ++raised) {
    if (std::abs(raised) < storey) continue;
    const double of_level = shareOn(of_map, level, raised, true) / level_here;
    if (of_level <= best.fit) continue;
    const double fit = std::min(of_level, shareOn(of_map, other, raised, false) / other_here);
    if (fit > best.fit) best = {raised * kVoxel_m, fit};
  }
  return best;
}

}  // namespace xview
