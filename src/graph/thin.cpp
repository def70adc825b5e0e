// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "graph/point_rows.h"
#include "xview/types/cells.h"

namespace xview::graph {
namespace {

struct Voxel {
  std::int32_t x, y, z;
  std::uint32_t label, instance;
  bool operator==(const Voxel& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label && instance == o.instance;
  }
  std::uint64_t hash() const {
    const auto pair = [](std::uint32_t high, std::uint32_t low) {
      return static_cast<std::uint64_t>(high) << 32 | low;
    };
    std::uint64_t h = pair(x, y) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 32)) + pair(z, label) * 0xBF58476D1CE4E5B9ull + instance * 0x94D049BB133111EBull;
    h = (h ^ (h >> 29)) * 0x2545F4914F6CDD1Dull;
    return h ^ (h >> 32);
  }
};

/// Sums of the points of a voxel, relative to its first point so that they stay small.
struct Sums {
  Voxel key;
  std::uint32_t count = 0;
  float first[3], offset[3] = {0, 0, 0};
  float sigma = 0;

  Point mean() const {
    const float weight = 1.0f / static_cast<float>(count);
    Point point(first[0] + offset[0] * weight, first[1] + offset[1] * weight,
                first[2] + offset[2] * weight, key.label);
    point.instance = key.instance;
    point.sigma = sigma * weight;
    return point;
  }
};

/// What thinByVoxel does, for points that come row by row and need never be held all at once.
class VoxelThinner {
 public:
  /// Points are relative to `origin`; `expected` of them, more or less.
  VoxelThinner(const Eigen::Vector3d& origin, double voxel_m, std::size_t expected)
      : origin_(origin), per_metre_(1 / voxel_m) {
    voxels_.reserve(expected / 8);  // few have one point only, and a small table stays in the cache
  }

  void add(const PointRow& row) {
    if (row.size == 0) return;
    findRuns(row);
    for (std::size_t run = 0; run + 1 < run_begin_.size(); ++run)
      addRun(row, run_begin_[run], run_begin_[run + 1]);
  }

  /// `points_per_voxel` receives how many points each one stands for, if it is given.
  LabelledCloud finish(std::vector<std::uint32_t>* points_per_voxel) const {
    LabelledCloud thin;
    thin.origin = origin_;
    thin.points.reserve(voxels_.size());
    if (points_per_voxel) points_per_voxel->clear();
    for (std::size_t i = 0; i < voxels_.size(); ++i) {
      thin.points.push_back(voxels_[i].mean());
      if (points_per_voxel) points_per_voxel->push_back(voxels_[i].count);
    }
    return thin;
  }

 private:
  /// Neighbouring measurements mostly share their voxel.
  void findRuns(const PointRow& row) {
    const std::size_t count = row.size;
    if (is_first_.size() < count) {
      for (auto* cells : {&cell_x_, &cell_y_, &cell_z_}) cells->resize(count);
      is_first_.resize(count);
    }
    const Eigen::Vector3d start = origin_ * per_metre_;
    cellsOf(row.x.data(), count, per_metre_, start.x(), cell_x_.data());
    cellsOf(row.y.data(), count, per_metre_, start.y(), cell_y_.data());
    cellsOf(row.z.data(), count, per_metre_, start.z(), cell_z_.data());
    std::fill_n(is_first_.begin(), count, std::uint8_t{0});
    for (const auto* cells : {&cell_x_, &cell_y_, &cell_z_})
      markChanges(reinterpret_cast<const std::uint32_t*>(cells->data()), count, is_first_.data());
    markChanges(row.label.data(), count, is_first_.data());
    markChanges(row.instance.data(), count, is_first_.data());
    is_first_[0] = 1;

    run_begin_.resize(count + 1);
    std::size_t runs = 0;
    for (std::size_t i = 0; i < count; ++i) {
      run_begin_[runs] = static_cast<std::uint32_t>(i);
      runs += is_first_[i];
    }
    run_begin_[runs] = static_cast<std::uint32_t>(count);
    run_begin_.resize(runs + 1);
  }

  void addRun(const PointRow& row, std::size_t begin, std::size_t end) {
    const Voxel voxel{cell_x_[begin], cell_y_[begin], cell_z_[begin], row.label[begin],
                      row.instance[begin]};
    if (voxel.x == kNoCell || voxel.y == kNoCell || voxel.z == kNoCell) return;
    Sums& sums = voxels_[voxels_.numberOf(voxel, [&] {
      return Sums{voxel, 0, {row.x[begin], row.y[begin], row.z[begin]}};
    })];
    float dx = sums.offset[0], dy = sums.offset[1], dz = sums.offset[2], sigma = sums.sigma;
    for (std::size_t i = begin; i < end; ++i) {
      dx += row.x[i] - sums.first[0];
      dy += row.y[i] - sums.first[1];
      dz += row.z[i] - sums.first[2];
      sigma += row.sigma[i];
    }
    sums.offset[0] = dx, sums.offset[1] = dy, sums.offset[2] = dz, sums.sigma = sigma;
    sums.count += static_cast<std::uint32_t>(end - begin);
  }

  Eigen::Vector3d origin_;
  double per_metre_;
  CellTable<Sums> voxels_;  ///< in order of first appearance
  std::vector<std::int32_t> cell_x_, cell_y_, cell_z_;
  std::vector<std::uint8_t> is_first_;    ///< of a run of points in one voxel
  std::vector<std::uint32_t> run_begin_;  ///< and the end
};

void gather(const LabelledCloud& cloud, std::size_t first, PointRow& row) {
  row.size = std::min(kPointsAtOnce, cloud.size() - first);
  for (std::size_t i = 0; i < row.size; ++i) {
    const Point& point = cloud.points[first + i];
    row.x[i] = point.x, row.y[i] = point.y, row.z[i] = point.z;
    row.label[i] = point.label;
    row.instance[i] = point.instance;
    row.sigma[i] = point.sigma;
  }
}

}  // namespace

LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel) {
  if (voxel_m <= 0) {
    if (points_per_voxel) points_per_voxel->assign(cloud.size(), 1);
    return cloud;
  }
  VoxelThinner thinner(cloud.origin, voxel_m, cloud.size());
  PointRow row(kPointsAtOnce);
  for (std::size_t first = 0; first < cloud.size(); first += row.size) {
    gather(cloud, first, row);
    thinner.add(row);
  }
  return thinner.finish(points_per_voxel);
}

ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts) {
  const LiftPlan plan = planOf(frame, options);
  ThinFrame result;
  result.whole.origin = plan.origin;
  VoxelThinner thinner(plan.origin, voxel_m, plan.expected);
  const auto isWanted = [&](std::uint32_t label) {
    return whole == WholeClasses::all || set.role(label) != Role::surface;
  };
  std::size_t near = 0;  // points not farther than kAerialQuantile_m
  const LiftCounts found = liftRows(frame, set, plan, [&](const PointRow& row) {
    thinner.add(row);
    for (std::size_t i = 0; i < row.size; ++i) {
      near += row.range[i] <= kAerialQuantile_m;
      if (whole != WholeClasses::none && isWanted(row.label[i]))
        result.whole.points.push_back(row.point(i));
    }
  });
  result.thin = thinner.finish(&result.points_per_voxel);
  result.is_aerial = frame.sensor == Sensor::camera && found.lifted > 0 && 10 * near < found.lifted;
  if (counts) *counts = found;
  return result;
}

}  // namespace xview::graph
