// SPDX-License-Identifier: BSD-3-Clause
// How distances are distributed at wrong poses in one map.
#include <algorithm>
#include <cmath>

#include "base/cells.h"
#include "base/random.h"
#include "search/distance_field.h"

namespace xview::search {
namespace {

constexpr int kDraws = 300;
constexpr double kSight_m = 30, kApart_m = 25;
constexpr double kBlock_m = 2;  ///< samples are thinned to one per block
constexpr std::uint64_t kSeed = 11;

double headingAt(const std::vector<Eigen::Vector2d>& path, std::size_t i) {
  const Eigen::Vector2d d = path[i + 1] - path[i - 1];
  return std::atan2(d.y(), d.x());
}

/// Samples of a channel in cells as wide as the sight, thinned.
class NearbySamples {
 public:
  /// `where`: the cells whose samples are enough.
  NearbySamples(const std::vector<BevSample>& samples, const CellIndex& where) : samples_(samples) {
    CellIndex taken;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const ClassCell cell = cellOf({samples[i].x, samples[i].y, 0}, kSight_m, 0);
      if (where.find(cell.x, cell.y) < 0) continue;
      const std::size_t before = taken.size();
      taken.findOrAdd(floorToInt(samples[i].x / kBlock_m), floorToInt(samples[i].y / kBlock_m));
      if (taken.size() > before) cells_.add(cell, i);
    }
  }
  template <class Body>
  void around(const Eigen::Vector2d& p, Body&& body) const {
    cells_.forAround(cellOf({p.x(), p.y(), 0}, kSight_m, 0), [&](std::size_t i) {
      const double x = samples_[i].x - p.x(), y = samples_[i].y - p.y();
      if (x * x + y * y <= kSight_m * kSight_m) body(x, y);
    });
  }

 private:
  const std::vector<BevSample>& samples_;
  CellLists cells_;
};

struct WrongPose {
  Eigen::Vector2d from, to;
  double yaw;
};

/// From or to a pose of the path that is not one of the first `known`.
std::vector<WrongPose> drawWrongPoses(const std::vector<Eigen::Vector2d>& path, std::size_t known) {
  std::vector<WrongPose> poses;
  Random random(kSeed + known);
  const double known_share = static_cast<double>(known) / static_cast<double>(path.size());
  const int draws = static_cast<int>(std::ceil(kDraws * (1 - known_share * known_share)));
  const std::size_t first = std::clamp<std::size_t>(known, 1, path.size() - 2);
  for (int draw = 0; draw < draws; ++draw) {
    std::size_t j = first + random.below(static_cast<std::uint32_t>(path.size() - 1 - first));
    std::size_t i = 1 + random.below(static_cast<std::uint32_t>(path.size() - 2));
    if (known > 0 && draw % 4 > 1) std::swap(i, j);
    const Eigen::Vector2d jitter(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
    const double yaw =
        headingAt(path, i) - headingAt(path, j) + (draw % 2 ? M_PI : 0) + random.uniform(-.03, .03);
    if ((path[i] - path[j]).norm() >= kApart_m) poses.push_back({path[j], path[i] + jitter, yaw});
  }
  return poses;
}

/// `in_sight`: cells as wide as the sight.
BevGrid partInSight(const StoredView& stored, const CellIndex& in_sight, const BevGrid& empty) {
  CellIndex columns;
  for (const PlaneCell& cell : in_sight.cells()) {
    const Eigen::Vector2d low = kSight_m * Eigen::Vector2d(cell.x, cell.y);
    addColumns({low, low + Eigen::Vector2d::Constant(kSight_m)}, columns);
  }
  return gathered(stored, columns, empty);
}

}  // namespace

std::uint64_t fingerprintOf(const BevGrid& map) {
  std::uint64_t weight = 1, sum = map.known.size();
  for (const auto& samples : map.samples) {
    weight *= 0x9E3779B97F4A7C15ull;
    sum += weight * samples.size();
  }
  return fingerprintOfSum(sum, 0);
}

std::uint64_t fingerprintOfSum(std::uint64_t a, std::uint64_t b) {
  return (a + b) & 0xFFFFFFFFFFFFull;  // a double holds it
}

PathNull mapNull(const BevGrid& map, const std::vector<Eigen::Vector2d>& path,
                 const DistanceField& field, const PathNull& known, const StoredView* stored) {
  const std::uint64_t view = stored ? stored->fingerprint() : fingerprintOf(map);
  if (path.size() < 4 || (known.poses > 0 && view == known.view)) return known;
  const bool has_grown = path.size() > known.poses;
  PathNull null{has_grown ? known.counts : MapNull{}, path.size(), view};
  const std::vector<WrongPose> poses = drawWrongPoses(path, has_grown ? known.poses : 0);
  CellIndex in_sight;
  for (const WrongPose& pose : poses) {
    const ClassCell cell = cellOf({pose.from.x(), pose.from.y(), 0}, kSight_m, 0);
    for (int i = 0; i < 9; ++i) in_sight.findOrAdd(cell.x + i % 3 - 1, cell.y + i / 3 - 1);
  }
  const BevGrid part = stored ? partInSight(*stored, in_sight, map) : BevGrid();
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const NearbySamples samples((stored ? part : map).samples[c], in_sight);
    for (const WrongPose& pose : poses) {
      const double cosine = std::cos(pose.yaw), sine = std::sin(pose.yaw);
      samples.around(pose.from, [&](double x, double y) {
        const double px = pose.to.x() + cosine * x - sine * y,
                     py = pose.to.y() + sine * x + cosine * y;
        const std::uint8_t bin = field.binAt(c, px, py);
        if (bin < kDistanceBins) ++null.counts[c][bin];
      });
    }
  }
  return null;
}

}  // namespace xview::search
