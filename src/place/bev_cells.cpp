// SPDX-License-Identifier: BSD-3-Clause
#include "place/bev_cells.h"

#include <algorithm>
#include <cmath>

#include "place/bev_grid.h"

namespace xview {
namespace {

constexpr float kMinHeight_m =
    0.25f;  ///< upright classes below this are labels spilt on the ground
constexpr float kLowFrom = 0.3f, kObstacleFrom = 0.4f, kLowTo = 2.0f, kHighFrom = 2.5f;
constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::none);

/// The voxels of each cell.
Grouped groupByCell(const BevVoxels& voxels, CellIndex& index) {
  std::vector<std::int32_t> cell_of(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i)
    cell_of[i] =
        index.findOrAdd(floorToInt(voxels[i].x / kBevCell_m), floorToInt(voxels[i].y / kBevCell_m));
  return Grouped(cell_of, index.size());
}

/// Gathers the weights of one cell after the other.
class CellSorter {
 public:
  explicit CellSorter(const GroundRule& rule) : gate_m_(static_cast<float>(rule.gate_m)) {}

  void start(float ground_height) {
    floor_ = {};
    floor_.height = ground_height;
    height_sum_ = 0;
    is_obstacle_ = false;
    obstacle_ = {};
    columns_.fill({});
  }

  void add(const BevVoxel& v) {
    floor_.total += v.weight_sum;
    const float height = v.z - floor_.height;
    if (!isGround(v.kind())) {
      addObstacle(v, height);
      if (height >= kMinHeight_m) addToColumn(v, height);
    } else if (std::abs(height) < gate_m_) {
      floor_.weight_sum[static_cast<std::size_t>(v.kind())] += v.weight_sum;
      height_sum_ += v.weight_sum * v.z;
    } else if (height > 0) {
      addObstacle(v, height);  // e.g. a crown labelled as terrain
    }
  }

  void finish(BevCells& cells) {
    const float ground_weight = floor_.ground();
    if (ground_weight > kMinWeight) floor_.height = height_sum_ / ground_weight;
    cells.floor.push_back(floor_);
    cells.obstacle_of.push_back(is_obstacle_ ? static_cast<std::int32_t>(cells.obstacles.size())
                                             : -1);
    if (!is_obstacle_) return;
    cells.obstacles.push_back(obstacle_);
    for (const ClassColumn& s : columns_) {
      if (s.weight_sum > 0) cells.columns.push_back(s);
    }
  }

 private:
  void addObstacle(const BevVoxel& v, float height) {
    is_obstacle_ = true;
    if (height > kObstacleFrom && height < kLowTo) obstacle_.obstacle_low += v.weight_sum;
    if (height > kHighFrom) obstacle_.obstacle_high += v.weight_sum;
  }

  void addToColumn(const BevVoxel& v, float height) {
    ClassColumn& s = columns_[static_cast<std::size_t>(v.kind())];
    s.kind = v.kind();
    s.bottom = s.weight_sum > 0 ? std::min(s.bottom, height) : height;
    s.top = s.weight_sum > 0 ? std::max(s.top, height) : height;
    s.weight_sum += v.weight_sum;
    s.near_weight += v.near_weight;
    s.sum_x += v.weight_sum * v.x;
    s.sum_y += v.weight_sum * v.y;
    if (height > kLowFrom && height < kLowTo) s.low += v.weight_sum;
    if (height > kHighFrom) s.high += v.weight_sum;
  }

  float gate_m_;
  FloorCell floor_;
  float height_sum_ = 0;
  bool is_obstacle_ = false;
  ObstacleCell obstacle_;
  std::array<ClassColumn, kKinds> columns_;
};

}  // namespace

const ClassColumn& ObstacleCell::of(Kind kind) const {
  static const ClassColumn kNothing;
  for (const ClassColumn* s = first; s != last; ++s) {
    if (s->kind == kind) return *s;
  }
  return kNothing;
}

float ObstacleCell::ofObjectsBesidePosts() const {
  return of(Kind::building).weight_sum + of(Kind::fence).weight_sum +
         of(Kind::vegetation).weight_sum + of(Kind::vehicle).weight_sum;
}

bool ObstacleCell::holds(Kind kind, double min_share) const {
  float total = 0;
  for (const ClassColumn* s = first; s != last; ++s) total += s->weight_sum;
  const float weight_sum = of(kind).weight_sum;
  return weight_sum >= kMinWeight && weight_sum >= min_share * total;
}

BevSample BevCells::middleOf(std::size_t i) const {
  constexpr auto kSide = static_cast<float>(kBevCell_m);
  const PlaneCell c = cell(i);
  return {(static_cast<float>(c.x) + 0.5f) * kSide, (static_cast<float>(c.y) + 0.5f) * kSide,
          floor[i].height};
}

BevCells sortIntoCells(const BevVoxels& voxels, const HeightLattice& ground,
                       const GroundRule& rule) {
  constexpr std::size_t kAhead = 16;  // voxels of a cell lie far apart in memory
  BevCells cells;
  const Grouped groups = groupByCell(voxels, cells.index);
  CellSorter sorter(rule);
  std::vector<std::size_t> first_column;
  for (std::size_t c = 0; c < cells.index.size(); ++c) {
    const PlaneCell cell = cells.cell(c);
    sorter.start(ground.heightAt(static_cast<float>((cell.x + 0.5) * kBevCell_m),
                                 static_cast<float>((cell.y + 0.5) * kBevCell_m)));
    for (std::size_t k = groups.starts[c]; k < groups.starts[c + 1]; ++k) {
      if (k + kAhead < groups.order.size()) __builtin_prefetch(&voxels[groups.order[k + kAhead]]);
      sorter.add(voxels[groups.order[k]]);
    }
    const std::size_t before = cells.columns.size();
    sorter.finish(cells);
    if (cells.obstacle_of[c] >= 0) first_column.push_back(before);
  }
  first_column.push_back(cells.columns.size());
  for (std::size_t u = 0; u < cells.obstacles.size(); ++u) {
    cells.obstacles[u].first = cells.columns.data() + first_column[u];
    cells.obstacles[u].last = cells.columns.data() + first_column[u + 1];
  }
  return cells;
}

ValueGrid::ValueGrid(const BevCells& cells, const std::function<float(const ObstacleCell&)>& value)
    : cells_(&cells), values_(cells.size(), 0.f) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (const ObstacleCell* cell = cells.obstacleCellOf(i)) values_[i] = value(*cell);
  }
}

ValueGrid ValueGrid::boxSum(int reach) const {
  ValueGrid sums = *this;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (values_[i] <= 0) continue;
    float& sum = sums.values_[i] = 0;
    cells_->index.forAround(i, reach, [&](std::int32_t j) { sum += values_[j]; });
  }
  return sums;
}

float ValueGrid::at(PlaneCell cell) const {
  const std::int32_t i = cells_->index.find(cell.x, cell.y);
  return i < 0 ? 0.f : values_[static_cast<std::size_t>(i)];
}

bool ValueGrid::isMaximum(std::size_t i, int reach) const {
  const PlaneCell c = cells_->cell(i);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const float other = at({c.x + dx, c.y + dy});
      const bool before = dy < 0 || (dy == 0 && dx < 0);
      if (other > values_[i] || (other == values_[i] && before)) return false;
    }
  }
  return true;
}

}  // namespace xview
